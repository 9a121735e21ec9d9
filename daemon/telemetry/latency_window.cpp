#include "daemon/telemetry/latency_window.hpp"

#include <algorithm>

namespace slipd {

void LatencyWindow::look(const LatencyHistogram& histogram, Clock::time_point now) {
  if (now < due_) return;
  due_ = now + kInterval;
  looks_[next_] = histogram.counts();
  next_ = (next_ + 1) % looks_.size();
}

LatencyHistogram::Summary LatencyWindow::summary(const LatencyHistogram& histogram) const {
  LatencyHistogram::Counts since = histogram.counts();
  const LatencyHistogram::Counts& before = looks_[next_];
  for (std::size_t i = 0; i < since.size(); ++i) since[i] -= before[i];
  LatencyHistogram::Summary result = LatencyHistogram::summary_of(since);
  // Nothing of the last minute took longer than anything ever did, which is known exactly.
  const double max_us = histogram.summary().max_us;
  for (double* value : {&result.p50_us, &result.p99_us, &result.p999_us, &result.max_us})
    *value = std::min(*value, max_us);
  return result;
}

}  // namespace slipd
