// JSON as people read it: tables for lists of objects, indented names and values for the rest.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace slipctl {

// Columns aligned, the first row being the heads; numbers to the right. Rows may be shorter than the first.
std::string table(const std::vector<std::vector<std::string>>& rows);

// The rows of a list of objects, one column for each of `keys`; absent and null are dashes.
std::string table_of(const nlohmann::ordered_json& objects, const std::vector<const char*>& keys);

// Any value: objects as `name  value` lines, lists of objects as tables, deeper ones indented.
std::string tree(const nlohmann::ordered_json& value, int indent = 0);

}  // namespace slipctl
