// Holds back lines of one kind about one sensor that come again and again (a cable that flaps): a few of them
// a minute are printed as they come, the rest are counted and told with the last one when the minute is over.
// io thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "daemon/rt/log_ring.hpp"

namespace slipd {

class LogLimit {
 public:
  using Clock = std::chrono::steady_clock;
  struct Held {
    LogLine last;
    std::uint64_t count = 0;  // that were not printed, the last one among them
  };

  static constexpr int kPrinted = 5;  // in each minute
  static constexpr auto kInterval = std::chrono::minutes(1);

  // Whether this line is to be printed now.
  bool admits(const LogLine& line, Clock::time_point now);

  // What was held back in minutes that are over. Often; looks at the clock only.
  std::vector<Held> over(Clock::time_point now);

 private:
  struct Kind {
    Clock::time_point until;
    int printed = 0;
    Held held;
  };
  using Key = std::pair<const char*, std::string>;  // the line's format, which is a literal, and its sensor
  std::map<Key, Kind> kinds_;                       // as many as there are formats and sensors at most
  Clock::time_point look_at_ = Clock::time_point::max();
};

}  // namespace slipd
