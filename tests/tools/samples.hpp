// Answers of a daemon whose gripper holds an object: estimates, frames, counts.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/slipctl/watch_state.hpp"

namespace slipctl::testing {

nlohmann::json estimate_sample(const std::string& sensor, std::uint64_t sequence, double gamma);
nlohmann::json frame_sample(int columns, int rows);  // pressed in the middle, sheared to the right
nlohmann::json sensors_sample(const std::vector<std::string>& names);
nlohmann::json status_sample(const std::vector<std::string>& names, std::uint64_t received);

// Sensors "s0" … with a history of ten seconds, in the given state; a sensor in state ok has a margin.
WatchState watch_sample(int sensors, const std::string& state = "ok");

}  // namespace slipctl::testing
