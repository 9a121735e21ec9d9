// Rate limit of log lines. Of lines with the same format and sensor, a few are printed in a window of a
// minute. The others are counted; when the window is over, the last one is printed with their number. If they
// go on, they are only counted, in windows that are twice as long each time, until one has none. Of one
// format, no more than some dozen are printed in a minute, whatever the number of sensors: when a bus fails,
// all its sensors say so.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "daemon/rt/log_ring.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: io.
class LogLimit {
 public:
  using Clock = std::chrono::steady_clock;
  // Lines of one kind that were not printed in a window.
  struct Suppressed {
    // The last line that was not printed.
    LogLine last;
    // Lines that were not printed, with the last one.
    std::uint64_t count = 0;
    // The window in which they came.
    std::chrono::minutes within{0};
  };

  // Lines of one kind and sensor that are printed in each window; the others are counted. More repeat
  // themselves in the journal.
  static constexpr int kPrintedPerWindow = 5;
  // Lines of one kind that are printed in each window, of all sensors together. More fill the journal when a
  // bus with many sensors fails, fewer hide which sensors are concerned.
  static constexpr int kPrintedOfAllSensors = 20;
  // Length of a window. A shorter one lets a lasting fault fill the journal, a longer one hides that it
  // lasts.
  static constexpr auto kWindow = std::chrono::minutes(1);
  // Longest window while lines keep coming, which doubles from kWindow on.
  static constexpr auto kLongestWindow = std::chrono::minutes(64);

  // Whether to print this line now. If not, it is counted.
  bool admits(const LogLine& line, Clock::time_point now);

  // What was suppressed in windows that are over, once. Cheap while none is over.
  std::vector<Suppressed> take_expired(Clock::time_point now);

 private:
  struct FormatState {
    Clock::time_point until;
    std::chrono::minutes window = kWindow;
    int printed = 0;
    Suppressed suppressed;
  };
  // Of one format, all sensors together.
  struct Budget {
    Clock::time_point until;
    int printed = 0;
  };
  using Key = std::pair<const char*, std::string>;  // the format, a literal, and the sensor
  std::map<Key, FormatState> formats_;              // at most as many as formats times sensors
  std::map<const char*, Budget> budgets_;
  Clock::time_point next_check_ = Clock::time_point::max();
};

}  // namespace slipd
