#include "tools/slipctl/watch_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/slipctl/number_text.hpp"

namespace slipctl {
namespace {

SensorCounts of(const std::vector<SensorCounts>& all, const std::string& name) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const SensorCounts& each) { return each.name == name; });
  return found == all.end() ? SensorCounts{} : *found;
}

SensorCounts between(const SensorCounts& before, SensorCounts after) {
  const auto since = [](std::uint64_t earlier, std::uint64_t& later) {
    later = later > earlier ? later - earlier : 0;
  };
  since(before.received, after.received);
  since(before.estimated, after.estimated);
  since(before.skipped, after.skipped);
  since(before.gaps, after.gaps);
  since(before.corrupt, after.corrupt);
  return after;
}

std::string shares(const SensorStatistics& statistics) {
  std::string text;
  for (const auto& [state, count] : statistics.states)
    text += (text.empty() ? "" : ", ") + state + " " +
            fixed(100.0 * static_cast<double>(count) / static_cast<double>(statistics.estimates), 1) + " %";
  return text;
}

}  // namespace

void WatchStatistics::take(const EstimateValues& estimate, bool is_estimate) {
  SensorStatistics& sensor = sensors_[estimate.name];
  // An alert event and its estimate arrive in either order: the first of them counts the rise.
  if (estimate.sequence >= sensor.sequence) {
    if (estimate.alert != sensor.alert) {
      if (estimate.alert == "warn" && sensor.alert != "slip") ++sensor.warnings;
      if (estimate.alert == "slip") ++sensor.slips;
    }
    sensor.alert = estimate.alert;
    sensor.sequence = estimate.sequence;
  }
  if (!is_estimate) return;
  ++sensor.estimates;
  ++sensor.states[estimate.state];
  sensor.dropped += estimate.dropped;
  if (!estimate.gamma) return;
  sensor.lowest = std::min(sensor.lowest.value_or(*estimate.gamma), *estimate.gamma);
  if (!estimate.true_gamma) return;
  const double error = std::abs(*estimate.gamma - *estimate.true_gamma);
  ++sensor.errors.count;
  sensor.errors.sum += error;
  sensor.errors.worst = std::max(sensor.errors.worst, error);
}

bool WatchStatistics::slip_seen() const {
  return std::any_of(sensors_.begin(), sensors_.end(),
                     [](const auto& each) { return each.second.slips > 0; });
}

std::string WatchStatistics::text(const std::vector<SensorCounts>& before,
                                  const std::vector<SensorCounts>& after, double seconds) const {
  std::string text;
  for (const auto& [name, statistics] : sensors_) {
    const SensorCounts counts = between(of(before, name), of(after, name));
    text += name + ": " + std::to_string(counts.received) + " frames in " + fixed(seconds, 1, "s") + " (" +
            rate(static_cast<double>(counts.received) / seconds) + "), " + std::to_string(counts.estimated) +
            " estimated, " + std::to_string(counts.skipped) + " skipped, " + std::to_string(counts.gaps) +
            " gaps\n";
    text += "  states: " + shares(statistics) + "\n";
    text += "  alerts: " + std::to_string(statistics.warnings) + " warnings, " +
            std::to_string(statistics.slips) + " slips; lowest margin " + fixed(statistics.lowest, 2) + "\n";
    if (const TruthErrors& errors = statistics.errors; errors.count > 0)
      text += "  against the simulation's truth: mean |error| " +
              fixed(errors.sum / static_cast<double>(errors.count), 4) + ", worst " + fixed(errors.worst, 3) +
              ", over " + std::to_string(errors.count) + " margins\n";
    if (statistics.dropped > 0)
      text += "  " + std::to_string(statistics.dropped) + " estimates were too many for this client\n";
  }
  return text;
}

nlohmann::ordered_json WatchStatistics::json(const std::vector<SensorCounts>& before,
                                             const std::vector<SensorCounts>& after, double seconds) const {
  nlohmann::ordered_json sensors = nlohmann::ordered_json::array();
  for (const auto& [name, statistics] : sensors_) {
    const SensorCounts counts = between(of(before, name), of(after, name));
    nlohmann::ordered_json sensor{{"name", name},
                                  {"received", counts.received},
                                  {"estimated", counts.estimated},
                                  {"skipped", counts.skipped},
                                  {"gaps", counts.gaps},
                                  {"seen", statistics.estimates},
                                  {"dropped", statistics.dropped},
                                  {"states", statistics.states},
                                  {"warnings", statistics.warnings},
                                  {"slips", statistics.slips},
                                  {"lowest_gamma", nullptr},
                                  {"mean_error", nullptr},
                                  {"worst_error", nullptr}};
    if (statistics.lowest) sensor["lowest_gamma"] = *statistics.lowest;
    if (statistics.errors.count > 0) {
      sensor["mean_error"] = statistics.errors.sum / static_cast<double>(statistics.errors.count);
      sensor["worst_error"] = statistics.errors.worst;
    }
    sensors.push_back(std::move(sensor));
  }
  return {{"seconds", seconds}, {"sensors", std::move(sensors)}};
}

}  // namespace slipctl
