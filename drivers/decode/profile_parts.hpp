// The two steps of parse_profile() behind the schema. Set-up thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "drivers/decode/profile.hpp"
#include "schema/schema.hpp"

namespace slipd::decode {

// JSON that fits the schema → Profile. What it cannot say goes to `problems`, and then the result is of no
// use.
Profile converted(const nlohmann::json& in, std::vector<Problem>& problems);

// What makes a profile unable to work though every key is in its range: bytes read twice, packets too short,
// taxels that no field fills or two do, packets that cannot be told apart, registers that are not there.
void find_contradictions(const nlohmann::json& in, const Profile& profile, std::vector<Problem>& problems);

}  // namespace slipd::decode
