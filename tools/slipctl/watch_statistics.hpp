// Statistics of each sensor over a run of `slipctl watch`, printed at its end.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/slipctl/rpc_values.hpp"

namespace slipctl {

// Errors |gamma - truth| of estimates in state ok of a simulated sensor.
struct TruthErrors {
  std::uint64_t count = 0;  // of estimates
  double sum = 0;           // of their errors
  double worst = 0;         // the largest error
};

struct SensorStatistics {
  std::uint64_t estimates = 0;
  std::uint64_t dropped = 0;                    // notifications lost because this client was too slow
  std::uint64_t warnings = 0;                   // times that the alert rose to warn
  std::uint64_t slips = 0;                      // times that the alert rose to slip
  std::map<std::string, std::uint64_t> states;  // estimates in each state
  std::optional<double> lowest;                 // lowest margin; absent: none was known
  TruthErrors errors;                           // of simulated sensors
  std::string alert = "none";                   // of the last notification
  std::uint64_t sequence = 0;                   // of the last notification
};

class WatchStatistics {
 public:
  void take(const EstimateValues& estimate,
            bool is_estimate);  // estimate or event; events count for alerts only
  bool slip_seen() const;

  // `before` and `after`: the daemon's counts at the begin and the end of `seconds`.
  std::string text(const std::vector<SensorCounts>& before, const std::vector<SensorCounts>& after,
                   double seconds) const;
  nlohmann::ordered_json json(const std::vector<SensorCounts>& before, const std::vector<SensorCounts>& after,
                              double seconds) const;

 private:
  std::map<std::string, SensorStatistics> sensors_;
};

}  // namespace slipctl
