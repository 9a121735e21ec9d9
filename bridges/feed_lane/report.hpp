// Log lines on a sensor's messages. Any thread.
#pragma once

#include <string>
#include <vector>

#include "bridges/feed_lane/lane.hpp"
#include "bridges/support/log.hpp"

namespace slipd::feed {

struct Line {
  bridges::LogLevel level;
  std::string text;
};

// What has changed between two accounts. Empty: nothing that people need to know.
std::vector<Line> report(const std::string& sensor, const Account& before, const Account& now);

// All counts, in one line.
std::string summary(const std::string& sensor, const Account& now);

}  // namespace slipd::feed
