// Parses JSON with comments, for files that people write. Called from any thread that may allocate: io,
// set-up, a tool.
//
// nlohmann's SAX parser reads the text into a builder of slipd's. The builder refuses a key that is given
// twice, of which nlohmann would keep one silently. It also limits the nesting, and gives line and column of
// these errors as of any other.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

namespace slipd {

// The first error in a text. what() does not contain the position.
class JsonTextError : public std::runtime_error {
 public:
  JsonTextError(std::size_t line, std::size_t column, const std::string& what)
      : std::runtime_error(what), line_(line), column_(column) {}
  // Line of the error, from 1.
  std::size_t line() const noexcept { return line_; }
  // Column of the error in characters, from 1: at what is wrong or just behind it.
  std::size_t column() const noexcept { return column_; }
  // `FILE:line:column: what`, with control characters escaped.
  std::string located_in(const std::string& file) const;

 private:
  std::size_t line_, column_;
};

// `text` with escapes for all characters that control a terminal (C0, DEL, C1).
std::string plain(std::string_view text);

// Deepest nesting of arrays and objects.
inline constexpr int kJsonDepth = 64;

// Parses a whole text. In the result every number is finite, every string is UTF-8, and nesting is at most
// kJsonDepth. Throws JsonTextError for the first error.
nlohmann::json parse_json_text(std::string_view text);

}  // namespace slipd
