// Writes JSON into a string, member by member, without a tree of values: for texts built a thousand times a
// second. Called from any one thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace slipd {

// Writes one object.
class ObjectText {
 public:
  // Appends to `out`, which outlives it. end() must be called once.
  explicit ObjectText(std::string& out) : out_(out) { out_ += '{'; }

  // Append a member. Keys are not escaped. Numbers are multiplied by `factor`; numbers that are not finite
  // are null. Others are the shortest text that reads back as the same double, with a point or an exponent.
  ObjectText& text(std::string_view key, std::string_view value);
  ObjectText& number(std::string_view key, std::optional<double> value, double factor = 1);
  ObjectText& integer(std::string_view key, std::optional<std::int64_t> value);
  ObjectText& boolean(std::string_view key, bool value);
  // Appends a key; the caller appends its value to the string returned.
  std::string& begin(std::string_view key);

  // Closes the object.
  void end() { out_ += '}'; }

 private:
  std::string& out_;
  bool first_ = true;
};

// Append a value as above; none: null.
void append_number(std::string& out, std::optional<double> value);
void append_integer(std::string& out, std::optional<std::int64_t> value);
// Appends `time_ns`, at least 0, in ms with all digits.
void append_ms(std::string& out, std::int64_t time_ns);
// Appends a string with quotes. Bytes that are not UTF-8 are replaced.
void append_text(std::string& out, std::string_view value);

}  // namespace slipd
