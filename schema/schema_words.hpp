// Describes schemas and values in words. Private to this room.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace slipd {

// The kind of a value: "a string", "an object", "an integer", …
std::string kind_of(const nlohmann::json& value);

// What a schema without $ref accepts: "a number from 0.1 to 100000 Hz", "one of "a", "b"", …
std::string wanted(const nlohmann::json& schema);

// The value as JSON on one line, at most 80 bytes.
std::string shown(const nlohmann::json& value);

// All parts as one text, with `between` after each but the last.
std::string joined(const std::vector<std::string>& parts, const char* between);

}  // namespace slipd
