// Latencies of the last minute: the difference between a histogram's counts now and a minute ago. Counts are
// stored every five seconds, so the window is 55 to 60 s long.
#pragma once

#include <array>
#include <chrono>

#include "daemon/board/latency.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: io. The histogram's writer may run.
class LatencyWindow {
 public:
  using Clock = std::chrono::steady_clock;

  // Stores the counts if five seconds have passed. To be called at least once a second.
  void update(const LatencyHistogram& histogram, Clock::time_point now);

  // Quantiles of the window. max_us is the upper edge of a bucket, exact within 13 %, and at most the
  // histogram's own maximum.
  LatencyHistogram::Summary summary(const LatencyHistogram& histogram) const;

 private:
  // Time between two snapshots; the window is twelve of them, a minute.
  static constexpr auto kInterval = std::chrono::seconds(5);
  std::array<LatencyHistogram::Counts, 12> snapshots_{};
  std::size_t next_ = 0;  // the oldest snapshot, which the next one replaces
  Clock::time_point due_{};
};

}  // namespace slipd
