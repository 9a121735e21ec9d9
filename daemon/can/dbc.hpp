// The DBC file of a configuration: config/slipd.dbc with its identifiers, its period, and the messages of
// each sensor and grasp. Called from any thread; allocates.
#pragma once

#include <string>
#include <vector>

#include "config/settings.hpp"

namespace slipd::can {

// What has messages, in the order of identifiers: sensors ("sensor left"), then grasps ("grasp gripper").
std::vector<std::string> source_names(const Settings& settings);

// The file's text. `sources`: from source_names, at most kMaxMessages.
std::string dbc_text(const CanSettings& can, const std::vector<std::string>& sources);

}  // namespace slipd::can
