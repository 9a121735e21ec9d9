// slipd-grip-ros2 itself: orders of slipd-grip come in lines, goals of an action go out. All of it runs in
// the loop's thread, when a line comes.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "bridges/grip_ros2/action.hpp"
#include "bridges/grip_ros2/goals.hpp"
#include "bridges/grip_ros2/settings.hpp"
#include "bridges/ros2/dds/cyclone_log.hpp"
#include "bridges/ros2/dds/host_watch.hpp"
#include "bridges/ros2/dds/node.hpp"
#include "bridges/support/line_socket.hpp"
#include "bridges/support/program.hpp"

namespace slipd::grip_ros2 {

class RosGripper : public bridges::Service {
 public:
  // Throws ros2::DdsError, std::runtime_error.
  RosGripper(const Settings& settings, bridges::Loop& loop);

 private:
  std::string obey(const std::string& line);
  void take(std::int64_t now_ns);
  std::string trouble(std::int64_t now_ns) const;
  void tell(const std::string& trouble);
  std::string answer(std::int64_t now_ns) const;

  Settings settings_;
  ros2::CycloneLog cyclone_;
  ros2::Node node_;
  ros2::HostWatch host_;
  GripperAction action_;
  Goals goals_;
  bool server_ = false;
  Fingers fingers_;
  std::int64_t fingers_ns_ = 0;  // when they were told; 0: never
  std::string told_;             // trouble
  bool told_abort_ = false;
  bridges::LineSocket socket_;
};

}  // namespace slipd::grip_ros2
