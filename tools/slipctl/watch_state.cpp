#include "tools/slipctl/watch_state.hpp"

#include <algorithm>

namespace slipctl {

void take_reading(WatchState& state, const EstimateView& reading) {
  const auto sensor = std::find_if(state.sensors.begin(), state.sensors.end(),
                                   [&](const SensorWatch& each) { return each.info.name == reading.sensor; });
  if (sensor == state.sensors.end()) return;
  sensor->latest = reading;
  sensor->course.push_back({state.elapsed_s, reading.gamma});
  while (sensor->course.front().time_s < state.elapsed_s - kCourseSeconds) sensor->course.pop_front();
}

void take_frame(SensorWatch& sensor, TaxelFrame frame) {
  for (const double pressure : frame.normal_pa) sensor.peak_pa = std::max(sensor.peak_pa, pressure);
  sensor.frame = std::move(frame);
}

}  // namespace slipctl
