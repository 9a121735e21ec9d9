// The rule of a feed's settings that all programs with feeds have.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "schema/schema.hpp"

namespace slipd::feed {

// A problem for each of settings["feeds"] whose "sensor" an earlier one has: two lanes would mix their
// frames.
std::vector<Problem> second_feeds(const nlohmann::json& settings);

}  // namespace slipd::feed
