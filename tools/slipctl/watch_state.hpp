// What `slipctl watch` knows at one moment: all that its views are drawn from.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "tools/slipctl/rpc_values.hpp"

namespace slipctl {

struct MarginPoint {
  double time_s = 0;  // on the watch's clock
  std::optional<double> gamma;
};

inline constexpr double kHistorySeconds = 10;

struct SensorWatch {
  SensorInfo info;
  std::optional<EstimateView> latest;
  std::deque<MarginPoint> history;  // the last kHistorySeconds, oldest first
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

// Takes a estimate in: the latest one and the history. Readings of sensors that are not watched are ignored.
void take_estimate(WatchState& state, const EstimateView& estimate);

void take_frame(SensorWatch& sensor, TaxelFrame frame);

}  // namespace slipctl
