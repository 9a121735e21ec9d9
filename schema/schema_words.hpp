// How schemas and values are put into words. Inside of schema.cpp, apart for size.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace slipd {

// What a value is: "a string", "an object", "an integer", …
std::string kind_of(const nlohmann::json& value);

// What a schema wants, without $ref: "a number from 0.1 to 100000 Hz", "one of "a", "b"", …
std::string wanted(const nlohmann::json& schema);

// A value as JSON on one line, shortened.
std::string shown(const nlohmann::json& value);

}  // namespace slipd
