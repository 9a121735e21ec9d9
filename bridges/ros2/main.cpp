// slipd-ros2: publishes slipd's estimates as a ROS 2 node, by DDS, without ROS.
#include "bridges/ros2/bridge.hpp"
#include "bridges/ros2/dds/node_settings.hpp"
#include "embedded/slipd_ros2_schema.hpp"

int main(int argc, char** argv) {
  using slipd::ros2::Ros2Bridge;
  return slipd::bridges::run_program(
      {.name = "slipd-ros2",
       .summary = "Publishes slipd's estimates as a ROS 2 node.",
       .schema = slipd::slipd_ros2_schema,
       .further = slipd::ros2::network_problems,
       .overrides = {{"--record", "record", "Also write all messages into this MCAP file"}}},
      argc, argv, [](const nlohmann::json& settings, slipd::bridges::Loop& loop) {
        return std::make_unique<Ros2Bridge>(settings, loop);
      });
}
