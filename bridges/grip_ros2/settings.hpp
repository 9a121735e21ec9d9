// slipd-grip-ros2's settings, as grip-ros2.schema.json describes them. Any thread that may allocate.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bridges/grip_ros2/action.hpp"
#include "bridges/grip_ros2/goals.hpp"
#include "bridges/ros2/dds/node.hpp"
#include "schema/schema.hpp"

namespace slipd::grip_ros2 {

struct Settings {
  std::string socket;  // where slipd-grip gives its orders
  ActionSettings action;
  GoalSettings goals;
  // From closed to open; none: the width is not told.
  std::optional<double> stroke_mm;
  ros2::NodeOptions node;
};

// What the schema cannot say.
std::vector<Problem> further_problems(const nlohmann::json& settings);

// From settings that have no problems.
Settings settings_of(const nlohmann::json& checked);

}  // namespace slipd::grip_ros2
