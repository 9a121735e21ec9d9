// What happened while `slipctl watch` was looking: counted per sensor, told at the end.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/slipctl/rpc_values.hpp"

namespace slipctl {

// How far the estimates in state ok lay off the simulation's truth.
struct TruthErrors {
  std::uint64_t count = 0;
  double sum = 0, worst = 0;  // of |gamma - truth|
};

struct SensorStatistics {
  std::uint64_t estimates = 0;
  std::uint64_t dropped = 0;              // notifications that this client was too slow for
  std::uint64_t warnings = 0, slips = 0;  // times that the alert rose to this level
  std::map<std::string, std::uint64_t> states;
  std::optional<double> lowest;  // margin
  TruthErrors errors;
  std::string alert = "none";  // the last one
  std::uint64_t sequence = 0;  // of the last one
};

class WatchStatistics {
 public:
  void take(const EstimateView& estimate,
            bool is_estimate);  // estimate or event; events count for alerts only
  bool slip_seen() const;

  // `before` and `after`: the daemon's own counts at both ends of `seconds`.
  std::string text(const std::vector<SensorCounts>& before, const std::vector<SensorCounts>& after,
                   double seconds) const;
  nlohmann::ordered_json json(const std::vector<SensorCounts>& before, const std::vector<SensorCounts>& after,
                              double seconds) const;

 private:
  std::map<std::string, SensorStatistics> sensors_;
};

}  // namespace slipctl
