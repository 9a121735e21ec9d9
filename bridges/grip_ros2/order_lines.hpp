// What slipd-grip and a gripper behind a program say to each other, a JSON object a line (docs/grip.md):
// orders in, what the gripper tells out. Any thread.
#pragma once

#include <optional>
#include <string>

#include "bridges/grip_ros2/goals.hpp"

namespace slipd::grip_ros2 {

// None: the line is no order.
std::optional<Order> order_of(const std::string& line);

// Numbers that are not finite are left out.
std::string answer_of(std::optional<double> width_mm, std::optional<double> force_n);
std::string fault(const std::string& what);

}  // namespace slipd::grip_ros2
