#include "bridges/feed_lane/second_feeds.hpp"

#include <nlohmann/json.hpp>
#include <set>

#include "schema/settings_error.hpp"

namespace slipd::feed {

std::vector<Problem> second_feeds(const nlohmann::json& settings) {
  std::vector<Problem> problems;
  std::set<std::string> sensors;
  const nlohmann::json& feeds = settings["feeds"];
  for (std::size_t i = 0; i < feeds.size(); ++i) {
    const nlohmann::json& sensor = feeds[i]["sensor"];
    if (!sensors.insert(sensor).second)
      problems.push_back(problem_of(pointer_to(pointer_to("/feeds", i), "sensor"), sensor,
                                    "has a feed already: a sensor has one"));
  }
  return problems;
}

}  // namespace slipd::feed
