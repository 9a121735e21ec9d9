#include "daemon/telemetry/latency_window.hpp"

#include <algorithm>

namespace slipd {

void LatencyWindow::update(const LatencyHistogram& histogram, Clock::time_point now) {
  if (now < due_) return;
  due_ = now + kInterval;
  snapshots_[next_] = histogram.counts();
  next_ = (next_ + 1) % snapshots_.size();
}

LatencyHistogram::Summary LatencyWindow::summary(const LatencyHistogram& histogram) const {
  LatencyHistogram::Counts since = histogram.counts();
  const LatencyHistogram::Counts& before = snapshots_[next_];
  for (std::size_t i = 0; i < since.size(); ++i) since[i] -= before[i];
  LatencyHistogram::Summary result = LatencyHistogram::summary_of(since);
  // The histogram's maximum is exact and bounds that of the window.
  const double max_us = histogram.summary().max_us;
  for (double* value : {&result.p50_us, &result.p99_us, &result.p999_us, &result.max_us})
    *value = std::min(*value, max_us);
  return result;
}

}  // namespace slipd
