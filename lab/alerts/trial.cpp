#include "lab/alerts/trial.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "core/advice/alert.hpp"
#include "lab/frames/simulated_frames.hpp"
#include "lab/grasp/drive.hpp"

namespace lab {
namespace {

using namespace slipd;

// A true margin below this is gross slip; no unit.
constexpr double kGrossSlip = 1e-9;

// The friction that the contact slides at, once it is closed.
double sliding_friction(const PresetBench& bench, const sim::SensorSettings& grasp) {
  sim::SimulatedSensor sensor(bench.layout, grasp);
  const std::int64_t closed_ns =
      grasp.cycle[0].duration_ns + grasp.cycle[1].duration_ns + grasp.cycle[2].duration_ns;
  sensor.advance(std::chrono::nanoseconds(closed_ns));
  return sensor.truth().friction;
}

void note(const GraspMoment& at, const Estimate& estimate, const sim::SimulatedSensor& sensor,
          AlertTrial& trial) {
  if (at.truth.gamma <= kGrossSlip && !trial.gross_slip_s) trial.gross_slip_s = at.time_s;
  if (!std::isnan(at.truth.gamma)) {
    ++trial.contact_frames;
    trial.answered_frames += estimate.gamma ? 1 : 0;
    trial.least_margin = std::min(trial.least_margin, at.truth.gamma);
  }
  if (is_raised(estimate.alert) && !trial.first_alert_s) {
    trial.first_alert_s = at.time_s;
    trial.cause = estimate.alert_cause;
    if (sensor.realistic() != nullptr) trial.slid_m = std::fabs(sensor.realistic()->contact().slid_m());
  }
  if (estimate.alert == Alert::slip && !trial.first_slip_s) trial.first_slip_s = at.time_s;
}

}  // namespace

std::vector<AlertTrialPair> run_preset_grasp(const PresetBench& bench, const sim::SensorSettings& grasp,
                                             std::span<const double> costs) {
  SimulatedFrames frames(bench, grasp);
  std::array<EstimatorChain, 2> chains{
      EstimatorChain(chain_of(bench, sliding_friction(bench, grasp)), nullptr),
      EstimatorChain(chain_of(bench, std::nullopt), nullptr)};
  std::vector<std::array<AlertLogic, 2>> judges;
  for (const double cost : costs) {
    const AlertLogic judge({.cost = cost});
    judges.push_back({judge, judge});
  }
  std::vector<AlertTrialPair> trials(costs.size());
  drive(frames, chains, [&](const GraspSample& sample) {
    for (std::size_t i = 0; i < costs.size(); ++i) {
      for (const std::size_t chain : {0U, 1U}) {
        Estimate estimate = sample.estimates[chain];
        judges[i][chain].judge(estimate);
        note(sample.at, estimate, frames.sensor(), chain == 0 ? trials[i].known : trials[i].unknown);
      }
    }
  });
  return trials;
}

AlertTrialPair run_preset_grasp(const PresetBench& bench, const sim::SensorSettings& grasp) {
  return run_preset_grasp(bench, grasp, std::array{AlertSettings{}.cost}).front();
}

}  // namespace lab
