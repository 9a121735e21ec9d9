// config/slipd.dbc for one configuration: its identifiers, its period, a pair of messages for each sensor and
// grasp. io thread.
#pragma once

#include <string>
#include <vector>

#include "config/settings.hpp"

namespace slipd::can {

// What has messages: the sensors in their order ("sensor left"), then the grasps ("grasp gripper").
std::vector<std::string> subjects_of(const Settings& settings);

// `subjects`: at most kMostMessages.
std::string dbc_text(const CanSettings& can, const std::vector<std::string>& sources);

}  // namespace slipd::can
