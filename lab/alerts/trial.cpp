#include "lab/alerts/trial.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

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

AlertTrialPair run_preset_grasp(const PresetBench& bench, const sim::SensorSettings& grasp) {
  SimulatedFrames frames(bench, grasp);
  std::array<EstimatorChain, 2> chains{
      EstimatorChain(chain_of(bench, sliding_friction(bench, grasp)), nullptr),
      EstimatorChain(chain_of(bench, std::nullopt), nullptr)};
  AlertTrialPair trials;
  drive(frames, chains, [&](const GraspSample& sample) {
    note(sample.at, sample.estimates[0], frames.sensor(), trials.known);
    note(sample.at, sample.estimates[1], frames.sensor(), trials.unknown);
  });
  return trials;
}

}  // namespace lab
