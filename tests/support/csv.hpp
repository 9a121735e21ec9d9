// Tables of comma-separated values without quotes, as slipd's programs print them.
#pragma once

#include <string>
#include <vector>

namespace slipd::testing {

// Fields of a line, empty ones too.
inline std::vector<std::string> row_fields(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

}  // namespace slipd::testing
