// slipd-feed-ros2's settings, as feed-ros2.schema.json describes them. Any thread that may allocate.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bridges/feed_ros2/topic_profile.hpp"
#include "bridges/ros2/dds/node.hpp"
#include "schema/schema.hpp"

namespace slipd::feed_ros2 {

// One sensor.
struct FeedSettings {
  std::string sensor;  // its name in slipd's configuration
  TopicProfile profile;
};

struct Settings {
  std::vector<FeedSettings> feeds;
  std::string socket;  // slipd's
  ros2::NodeOptions node;
};

// What the schema cannot say: profiles, topics, addresses.
std::vector<Problem> further_problems(const nlohmann::json& settings);

// From settings that have no problems.
Settings settings_of(const nlohmann::json& checked);

}  // namespace slipd::feed_ros2
