// Frames told to the chain, each for itself after a grip without shear: what it says of contacts at the ends
// of the world, and of those that are not its model.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/estimate/chain.hpp"
#include "core/estimate/trial_frames.hpp"
#include "tools/sliplab/stability/adversary.hpp"
#include "tools/sliplab/stability/extremes.hpp"
#include "tools/sliplab/tally.hpp"

namespace sliplab {

struct TrialSetup {
  std::size_t side = 32;  // taxels along each side of a pad of +-8 mm
  slipd::NoiseKind kind = slipd::NoiseKind::sensor;
  double noise = 0.01;
  std::size_t contacts = 200;  // of each row
  std::uint64_t seed = 1;
  unsigned threads = 2;
};

// The paper's contacts on that pad, up to 2 mm off the middle.
slipd::TaxelLayout layout_of(const TrialSetup& setup);
slipd::Scene scene_of(const TrialSetup& setup);

// Methods that need no training.
struct Untrained {
  slipd::MethodChoice choice;
  const char* name;
};
inline constexpr Untrained kUntrained[] = {{slipd::MethodChoice::moments, "moments"},
                                           {slipd::MethodChoice::fit, "fit"}};

struct Ordeal {
  std::string what;  // the axis or the flaw
  double strength;
  std::vector<Tally> by_method;  // as kUntrained
};

using Done = std::function<void(double share)>;
std::vector<Ordeal> tell_extremes(const TrialSetup& setup, const Done& done);
std::vector<Ordeal> tell_flaws(const TrialSetup& setup, const Done& done);

}  // namespace sliplab
