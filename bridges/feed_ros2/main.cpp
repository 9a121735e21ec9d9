// slipd-feed-ros2's command line; slipd-feed-ros2(8).
#include "bridges/feed_ros2/topics.hpp"
#include "embedded/slipd_feed_ros2_schema.hpp"

int main(int argc, char** argv) {
  using namespace slipd;
  return bridges::run_program(
      {"slipd-feed-ros2", "Hands frames from ROS 2 topics to slipd", slipd_feed_ros2_schema,
       feed_ros2::further_problems},
      argc, argv,
      [](const nlohmann::json& settings, bridges::Loop& loop) -> std::unique_ptr<bridges::Service> {
        return std::make_unique<feed_ros2::Topics>(feed_ros2::settings_of(settings), loop);
      });
}
