// JSON with comments → nlohmann::json, for files that people write. Set-up only, the io thread or a tool.
//
// nlohmann's own parser reads it, but into a builder of ours: it alone can refuse a key given twice (of which
// one would silently win) and nesting that later recursion could not bear, and say line and column for these
// as for any error.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

namespace slipd {

class JsonTextError : public std::runtime_error {
 public:
  JsonTextError(std::size_t line, std::size_t column, const std::string& what)
      : std::runtime_error(what), line_(line), column_(column) {}
  std::size_t line() const noexcept { return line_; }  // from 1
  std::size_t column() const noexcept {
    return column_;
  }  // from 1, in characters; just behind what is wrong or on it
  std::string located_in(const std::string& file) const;  // `FILE:line:column: what`

 private:
  std::size_t line_, column_;
};

// `text` with escapes for all that a terminal would obey instead of showing it (C0, DEL, C1).
std::string plain(std::string_view text);

inline constexpr int kJsonDepth = 64;

// Every number in the result is finite, every string UTF-8, nothing lies deeper than kJsonDepth.
// Throws JsonTextError for the first error.
nlohmann::json parse_json_text(std::string_view text);

}  // namespace slipd
