// The steps of parse_profile() that follow the check against the schema. Set-up thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "drivers/decode/profile.hpp"
#include "schema/schema.hpp"

namespace slipd::decode {

// Converts JSON that fits the schema. Appends what cannot be converted to `problems`; then the result is
// invalid.
Profile converted(const nlohmann::json& in, std::vector<Problem>& problems);

// Appends what lies behind the packet's end: fields, clock, counter, match and key; and bytes that two fields
// read. `at`: JSON pointer to the packet. Does not look at fields that a usage places.
void find_misplaced(const Profile& profile, const PacketRule& rule, const std::string& at,
                    std::vector<Problem>& problems);

// Appends the contradictions of a profile whose every key is in its range: bytes that two fields read,
// packets that are too short, taxels that no field or two fields fill, packets that cannot be distinguished,
// registers that the device does not have, ids and checksums that no packet can have.
void find_contradictions(const nlohmann::json& in, const Profile& profile, std::vector<Problem>& problems);

}  // namespace slipd::decode
