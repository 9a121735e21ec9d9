#include "bridges/feed_ros2/settings.hpp"

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "bridges/feed_lane/second_feeds.hpp"
#include "bridges/ros2/dds/node_settings.hpp"
#include "schema/settings_error.hpp"

namespace slipd::feed_ros2 {
namespace {

using nlohmann::json;

TopicProfile profile_of(const json& feed) {
  return find_topic_profile(feed["profile"], {feed.value("topic", ""), feed.value("frame_id", ""),
                                              feed.value("taxels", std::size_t{0})});
}

// `types`: of the topics of the feeds before.
void check_feed(const json& feed, const std::string& at, std::map<std::string, TopicType>& types,
                std::vector<Problem>& problems) {
  try {
    const TopicProfile profile = profile_of(feed);
    if (profile.topic.empty())
      problems.push_back(problem_of(at, feed, "the profile names no topic: add \"topic\""));
    else if (types.emplace(profile.topic, profile.type).first->second != profile.type)
      problems.push_back(problem_of(
          at, feed, "another feed has the topic " + profile.topic + " with another type: a topic has one"));
  } catch (const SettingsError& error) {
    for (const std::string& problem : error.problems())
      problems.push_back(problem_of(pointer_to(at, "profile"), feed["profile"], problem));
  }
}

}  // namespace

std::vector<Problem> further_problems(const json& settings) {
  std::vector<Problem> problems = ros2::network_problems(settings);
  for (Problem& problem : feed::second_feeds(settings)) problems.push_back(std::move(problem));
  std::map<std::string, TopicType> types;
  for (std::size_t i = 0; i < settings["feeds"].size(); ++i) {
    check_feed(settings["feeds"][i], pointer_to("/feeds", i), types, problems);
  }
  return problems;
}

Settings settings_of(const json& checked) {
  Settings settings;
  settings.socket = checked["socket"];
  settings.node = ros2::node_options(checked);
  for (const json& feed : checked["feeds"]) settings.feeds.push_back({feed["sensor"], profile_of(feed)});
  return settings;
}

}  // namespace slipd::feed_ros2
