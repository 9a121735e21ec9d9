// JSON written straight into a string, member by member: what is said a thousand times a second takes no tree
// of values first. io thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace slipd {

class ObjectText {
 public:
  // An object that is written at the end of `out`: opened here, to be closed once by end().
  explicit ObjectText(std::string& out) : out_(out) { out_ += '{'; }

  // Keys are literals of the program: nothing in them needs escaping. Numbers that are not finite are null;
  // all others are the shortest text that reads back as the same double, with a point or exponent in it.
  ObjectText& text(std::string_view key, std::string_view value);
  ObjectText& number(std::string_view key, std::optional<double> value, double factor = 1);
  ObjectText& integer(std::string_view key, std::optional<std::int64_t> value);
  ObjectText& boolean(std::string_view key, bool value);
  std::string& begin(std::string_view key);  // the value is to be appended to what it returns

  void end() { out_ += '}'; }

 private:
  std::string& out_;
  bool first_ = true;
};

void append_number(std::string& out, std::optional<double> value);
void append_integer(std::string& out, std::optional<std::int64_t> value);
// Of a time >= 0 in ns, in ms to the last digit.
void append_ms(std::string& out, std::int64_t time_ns);
void append_text(std::string& out, std::string_view value);  // quoted; bytes that are no UTF-8 are replaced

}  // namespace slipd
