// The state of `slipctl watch`, from which its views are drawn.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "tools/slipctl/grip_watch.hpp"
#include "tools/slipctl/rpc_values.hpp"

namespace slipctl {

struct MarginPoint {
  double time_s = 0;            // since the watch began
  std::optional<double> gamma;  // margin; absent: unknown
};

// Length of the margin's history on the screen, s.
inline constexpr double kHistorySeconds = 10;

struct SensorWatch {
  SensorInfo info;
  std::optional<EstimateValues> latest;  // absent: none has arrived
  std::deque<MarginPoint> history;       // of the last kHistorySeconds, oldest first
  TaxelFrame frame;                      // the latest; empty: none
  double peak_pa = 0;                    // highest pressure so far, the map's scale
  std::optional<SensorCounts> counts;    // absent: not requested yet
};

struct WatchState {
  std::string socket;                // path of the daemon's socket
  bool connected = true;             // false: slipd is gone; the watch waits for it
  double elapsed_s = 0;              // since the watch began
  std::vector<SensorWatch> sensors;  // those that are watched
  std::vector<EstimateValues> grasps;
  std::optional<GripWatch> grip;  // absent: no slipd-grip runs here
};

// Stores an estimate as the latest one and in the history. Ignores sensors that are not watched.
void take_estimate(WatchState& state, const EstimateValues& estimate);

void take_frame(SensorWatch& sensor, TaxelFrame frame);

}  // namespace slipctl
