#include "tools/slipctl/watch_state.hpp"

#include <algorithm>

namespace slipctl {

void take_estimate(WatchState& state, const EstimateValues& estimate) {
  const auto sensor = std::find_if(state.sensors.begin(), state.sensors.end(),
                                   [&](const SensorWatch& each) { return each.info.name == estimate.name; });
  if (sensor == state.sensors.end()) return;
  sensor->latest = estimate;
  sensor->history.push_back({state.elapsed_s, estimate.gamma});
  while (sensor->history.front().time_s < state.elapsed_s - kHistorySeconds) sensor->history.pop_front();
}

void take_frame(SensorWatch& sensor, TaxelFrame frame) {
  for (const double pressure : frame.normal_pa) sensor.peak_pa = std::max(sensor.peak_pa, pressure);
  sensor.frame = std::move(frame);
}

}  // namespace slipctl
