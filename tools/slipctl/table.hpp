// Formats JSON for people: tables for lists of objects, indented names and values for the rest.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace slipctl {

// Aligned columns; the first row holds the headings; numbers are right-aligned. Rows can be shorter than the
// first.
std::string table(const std::vector<std::vector<std::string>>& rows);

// A list of objects as a table with one column for each of `keys`; absent and null values are dashes.
std::string table_of(const nlohmann::ordered_json& objects, const std::vector<const char*>& keys);

// Any value: objects as `name  value` lines, lists of objects as tables, deeper ones indented.
std::string tree(const nlohmann::ordered_json& value, int indent = 0);

}  // namespace slipctl
