#include "daemon/serve/latency_window.hpp"

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
  return LatencyHistogram::summary_of(since);
}

}  // namespace slipd
