// A bridge's settings: a file of JSON with comments, checked against the bridge's JSON Schema. Called from
// any thread that may wait for the disk.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "schema/schema.hpp"
#include "schema/settings_error.hpp"

namespace slipd::bridges {

// Rules that a schema cannot state. Gets settings that fit the schema, and may return problems.
using FurtherCheck = std::function<std::vector<Problem>(const nlohmann::json& settings)>;

// Largest settings file, bytes.
inline constexpr std::size_t kLargestSettings = std::size_t{1} << 20;

// Checks `text` and fills in the schema's defaults. `name` is the file's name in problems. Throws
// SettingsError; SchemaError or JsonTextError if `schema` itself is wrong.
nlohmann::json parse_settings(std::string_view text, const std::string& name, std::string_view schema,
                              const FurtherCheck& further = {});

// The same of a regular file. Throws SettingsError, also for a file that cannot be read.
nlohmann::json load_settings(const std::filesystem::path& file, std::string_view schema,
                             const FurtherCheck& further = {});

}  // namespace slipd::bridges
