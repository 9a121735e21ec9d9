// What the chain raised in one grasp of a simulated preset.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/estimate/estimate.hpp"
#include "lab/frames/preset_grasp.hpp"

namespace lab {

// What was raised in one grasp; times in s since it began.
struct AlertTrial {
  std::optional<double> gross_slip_s;   // when the true margin reached 0
  std::optional<double> first_alert_s;  // of any level
  std::optional<double> first_slip_s;   // of level slip
  std::optional<double> slid_m;  // how far the object had slid at the first alert, m; preset ideal: none
  slipd::AlertCause cause = slipd::AlertCause::none;  // of the first alert
  double least_margin = 1;                            // true, over all frames in contact
  std::size_t contact_frames = 0;                     // with a true margin
  std::size_t answered_frames = 0;                    // of these, with a margin from the chain
};

// Of two chains: with the friction that this contact slides at, and without it.
struct AlertTrialPair {
  AlertTrial known, unknown;
};
// One grasp through both, its estimates judged at each cost of a slip that is not told (AlertSettings::cost).
std::vector<AlertTrialPair> run_preset_grasp(const PresetBench& bench,
                                             const slipd::sim::SensorSettings& grasp,
                                             std::span<const double> costs);
// At the default cost.
AlertTrialPair run_preset_grasp(const PresetBench& bench, const slipd::sim::SensorSettings& grasp);

}  // namespace lab
