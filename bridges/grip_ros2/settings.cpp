#include "bridges/grip_ros2/settings.hpp"

#include <nlohmann/json.hpp>

#include "bridges/ros2/dds/node_settings.hpp"

namespace slipd::grip_ros2 {
namespace {

constexpr double kMsPerSecond = 1000;

}  // namespace

std::vector<Problem> further_problems(const nlohmann::json& settings) {
  std::vector<Problem> problems = ros2::network_problems(settings);
  if (settings["open"] == settings["closed"])
    problems.push_back(
        problem_of("/open", settings["open"], "is the same as closed: the gripper never moves"));
  if (settings["type"] == "ParallelGripperCommand" && !settings.contains("joint"))
    problems.push_back(problem_of("/type", settings["type"],
                                  "needs \"joint\", the name of the joint that the driver commands"));
  return problems;
}

Settings settings_of(const nlohmann::json& checked) {
  Settings settings;
  settings.socket = checked["socket"];
  settings.action = {
      .name = checked["action"],
      .type = checked["type"] == "GripperCommand" ? ActionType::gripper_command
                                                  : ActionType::parallel_gripper_command,
      .joint = checked.value("joint", ""),
      .middleware = checked["middleware"] == "fastdds" ? Middleware::fastdds : Middleware::cyclonedds};
  settings.goals = {.open = checked["open"],
                    .closed = checked["closed"],
                    .effort_per_n = checked["effort_per_n"],
                    .open_effort = checked["open_effort"],
                    .goals_per_s = checked["goals_per_s"],
                    .accept_s = checked["accept_ms"].get<double>() / kMsPerSecond};
  if (checked.contains("stroke_mm")) settings.stroke_mm = checked["stroke_mm"].get<double>();
  settings.node = ros2::node_options(checked);
  return settings;
}

}  // namespace slipd::grip_ros2
