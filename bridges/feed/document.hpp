// A text of a message as a JSON document. Any thread; any bytes are valid input.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>

namespace slipd::feed {

// False: it is no JSON text.
bool parse_json(std::span<const std::uint8_t> text, nlohmann::json& out);
// The same of a YAML text. False also where it has more than some thousand values, counting those that
// aliases repeat.
bool parse_yaml(std::span<const std::uint8_t> text, nlohmann::json& out);

}  // namespace slipd::feed
