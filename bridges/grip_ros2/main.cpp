// slipd-grip-ros2's command line; slipd-grip-ros2(8).
#include "bridges/grip_ros2/gripper.hpp"
#include "embedded/slipd_grip_ros2_schema.hpp"

int main(int argc, char** argv) {
  using namespace slipd;
  return bridges::run_program(
      {"slipd-grip-ros2", "Passes slipd-grip's orders on to a gripper of ROS 2", slipd_grip_ros2_schema,
       grip_ros2::further_problems},
      argc, argv,
      [](const nlohmann::json& settings, bridges::Loop& loop) -> std::unique_ptr<bridges::Service> {
        return std::make_unique<grip_ros2::RosGripper>(grip_ros2::settings_of(settings), loop);
      });
}
