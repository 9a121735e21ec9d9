// A text of a message as a JSON document. Any thread; any bytes are valid input.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>

namespace slipd::feed {

// Lists and objects within each other. Fewer: texts with more around the values are refused. More: whatever
// walks a document by recursion takes more of the stack.
constexpr int kDeepestDocument = 16;

// False: it is no JSON text, or is nested too deeply.
bool parse_json(std::span<const std::uint8_t> text, nlohmann::json& out);
// The same of a YAML text. False also where it has more than some thousand values, counting those that
// aliases repeat.
bool parse_yaml(std::span<const std::uint8_t> text, nlohmann::json& out);

}  // namespace slipd::feed
