// Latencies of the last minute: what a histogram has counted since it was looked at a minute ago. It is
// looked at every five seconds, so the window is 55 to 60 s long. io thread; the histogram's writer notices
// nothing.
#pragma once

#include <array>
#include <chrono>

#include "daemon/board/latency.hpp"

namespace slipd {

class LatencyWindow {
 public:
  using Clock = std::chrono::steady_clock;

  // Often, at least once a second. Looks only when it is time.
  void look(const LatencyHistogram& histogram, Clock::time_point now);

  // max_us is a bucket's upper edge here, exact within 13 %, and never above that of all time.
  LatencyHistogram::Summary summary(const LatencyHistogram& histogram) const;

 private:
  static constexpr auto kInterval = std::chrono::seconds(5);
  std::array<LatencyHistogram::Counts, 12> looks_{};
  std::size_t next_ = 0;  // the oldest look, which the next one replaces
  Clock::time_point due_{};
};

}  // namespace slipd
