#include "tools/slipctl/tally.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/slipctl/figures.hpp"

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

std::string shares(const SensorTally& tally) {
  std::string text;
  for (const auto& [state, count] : tally.states)
    text += (text.empty() ? "" : ", ") + state + " " +
            fixed(100.0 * static_cast<double>(count) / static_cast<double>(tally.estimates), 1) + " %";
  return text;
}

}  // namespace

void Tally::take(const EstimateView& reading, bool is_estimate) {
  SensorTally& sensor = sensors_[reading.sensor];
  // An event and the estimate that it belongs to come in either order: a rise is counted with the first of
  // them.
  if (reading.sequence >= sensor.sequence) {
    if (reading.alert != sensor.alert) {
      if (reading.alert == "warn" && sensor.alert == "none") ++sensor.warnings;
      if (reading.alert == "slip") ++sensor.slips;
    }
    sensor.alert = reading.alert;
    sensor.sequence = reading.sequence;
  }
  if (!is_estimate) return;
  ++sensor.estimates;
  ++sensor.states[reading.state];
  sensor.dropped += reading.dropped;
  if (!reading.gamma) return;
  sensor.lowest = std::min(sensor.lowest.value_or(*reading.gamma), *reading.gamma);
  if (!reading.true_gamma) return;
  const double error = std::abs(*reading.gamma - *reading.true_gamma);
  ++sensor.errors.count;
  sensor.errors.sum += error;
  sensor.errors.worst = std::max(sensor.errors.worst, error);
}

bool Tally::slip_seen() const {
  return std::any_of(sensors_.begin(), sensors_.end(),
                     [](const auto& each) { return each.second.slips > 0; });
}

std::string Tally::text(const std::vector<SensorCounts>& before, const std::vector<SensorCounts>& after,
                        double seconds) const {
  std::string text;
  for (const auto& [name, tally] : sensors_) {
    const SensorCounts counts = between(of(before, name), of(after, name));
    text += name + ": " + std::to_string(counts.received) + " frames in " + fixed(seconds, 1, "s") + " (" +
            rate(static_cast<double>(counts.received) / seconds) + "), " + std::to_string(counts.estimated) +
            " estimated, " + std::to_string(counts.skipped) + " skipped, " + std::to_string(counts.gaps) +
            " gaps\n";
    text += "  states: " + shares(tally) + "\n";
    text += "  alerts: " + std::to_string(tally.warnings) + " warnings, " + std::to_string(tally.slips) +
            " slips; lowest margin " + fixed(tally.lowest, 2) + "\n";
    if (const TruthErrors& errors = tally.errors; errors.count > 0)
      text += "  against the simulation's truth: mean |error| " +
              fixed(errors.sum / static_cast<double>(errors.count), 4) + ", worst " + fixed(errors.worst, 3) +
              ", over " + std::to_string(errors.count) + " margins\n";
    if (tally.dropped > 0)
      text += "  " + std::to_string(tally.dropped) + " estimates were too many for this client\n";
  }
  return text;
}

nlohmann::ordered_json Tally::json(const std::vector<SensorCounts>& before,
                                   const std::vector<SensorCounts>& after, double seconds) const {
  nlohmann::ordered_json sensors = nlohmann::ordered_json::array();
  for (const auto& [name, tally] : sensors_) {
    const SensorCounts counts = between(of(before, name), of(after, name));
    nlohmann::ordered_json sensor{{"name", name},
                                  {"received", counts.received},
                                  {"estimated", counts.estimated},
                                  {"skipped", counts.skipped},
                                  {"gaps", counts.gaps},
                                  {"seen", tally.estimates},
                                  {"dropped", tally.dropped},
                                  {"states", tally.states},
                                  {"warnings", tally.warnings},
                                  {"slips", tally.slips},
                                  {"lowest_gamma", nullptr},
                                  {"mean_error", nullptr},
                                  {"worst_error", nullptr}};
    if (tally.lowest) sensor["lowest_gamma"] = *tally.lowest;
    if (tally.errors.count > 0) {
      sensor["mean_error"] = tally.errors.sum / static_cast<double>(tally.errors.count);
      sensor["worst_error"] = tally.errors.worst;
    }
    sensors.push_back(std::move(sensor));
  }
  return {{"seconds", seconds}, {"sensors", std::move(sensors)}};
}

}  // namespace slipctl
