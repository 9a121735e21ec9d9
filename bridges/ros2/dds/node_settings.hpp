// The keys of a settings file that say which nodes are to be met: domain, distribution, node and network, as
// ros2.schema.json describes them. Any thread that may allocate.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "bridges/ros2/dds/node.hpp"
#include "schema/schema.hpp"

namespace slipd::ros2 {

// Problems of settings that fit the schema: addresses.
std::vector<Problem> network_problems(const nlohmann::json& settings);

// Of settings without problems.
NodeOptions node_options(const nlohmann::json& settings);

}  // namespace slipd::ros2
