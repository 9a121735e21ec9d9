// What `slipctl watch` knows at one moment: all that its views are drawn from.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "tools/slipctl/readings.hpp"

namespace slipctl {

struct CoursePoint {
  double time_s = 0;  // on the watch's clock
  std::optional<double> gamma;
};

inline constexpr double kCourseSeconds = 10;

struct SensorWatch {
  SensorInfo info;
  std::optional<EstimateView> latest;
  std::deque<CoursePoint> course;  // the last kCourseSeconds, oldest first
  TaxelFrame frame;
  double peak_pa = 0;  // highest pressure so far: the map's scale
  std::optional<SensorCounts> counts;
};

struct WatchState {
  std::string socket;
  double elapsed_s = 0;
  std::vector<SensorWatch> sensors;
  std::vector<EstimateView> grasps;  // `sensor` is the grasp's name
};

// Takes a reading in: the latest one and the course. Readings of sensors that are not watched are ignored.
void take_reading(WatchState& state, const EstimateView& reading);

void take_frame(SensorWatch& sensor, TaxelFrame frame);

}  // namespace slipctl
