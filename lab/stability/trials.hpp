// Trials of the estimator chain with single contacts, each after a grip without shear: at extreme parameters,
// and with perturbations of the contact model.
#pragma once

#include <string>
#include <vector>

#include "core/chain/chain.hpp"
#include "lab/collect.hpp"
#include "lab/stability/adversary.hpp"
#include "lab/stability/extremes.hpp"
#include "lab/tally/tally.hpp"
#include "paper/validation/trial_frames.hpp"

namespace lab {

struct TrialSetup {
  std::size_t side = 32;                             // taxels along each side of a pad of +-8 mm
  slipd::NoiseKind kind = slipd::NoiseKind::sensor;  // what the noise is a fraction of
  double noise = 0.01;                               // half-width, a fraction
  std::size_t contacts = 200;                        // per row
  std::uint64_t seed = 1;                            // of contacts and noise
  unsigned threads = 2;
};

// The paper's contacts on that pad, up to 2 mm off its middle.
slipd::TaxelLayout layout_of(const TrialSetup& setup);
slipd::Scene scene_of(const TrialSetup& setup);

// Methods that need no training.
struct Untrained {
  slipd::MethodChoice choice;
  const char* name;  // in tables
};
inline constexpr Untrained kUntrained[] = {{slipd::MethodChoice::moments, "moments"},
                                           {slipd::MethodChoice::fit, "fit"}};

// The errors at one value of an axis or one strength of a perturbation.
struct RobustnessRow {
  std::string what;              // name of the axis or the perturbation
  double strength;               // value on the axis or strength of the perturbation
  std::vector<Tally> by_method;  // in the order of kUntrained
  std::size_t not_finite = 0;    // estimates with a number that is not; of measure_turning only
};

std::vector<RobustnessRow> measure_extremes(const TrialSetup& setup, const Done& done);
std::vector<RobustnessRow> measure_perturbations(const TrialSetup& setup, const Done& done);

}  // namespace lab
