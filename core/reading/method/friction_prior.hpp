// What friction is expected before any frame: a range of mu whose ends are soft (docs/methods.md §28.1).
// Shared by all that weigh friction, so that one frame and many frames expect the same.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/contact/scene.hpp"

namespace slipd {

// Checked with `slipd-lab histories --grasps 400` and `slipd-lab tradeoff`.
// Friction whose sigma is below this is given with an estimate, and under a torque gives a margin, also by
// memory; relative, 0.02 … 0.4. Too small: grip advice comes late, and only heavy torques get an answer. Too
// large: advice is from a guess, and friction that a light pull has shown gives heavier loads margins that
// are too safe.
inline constexpr double kKnownFriction = 0.2;

// Friction is open until its sigma is below this, and under a torque it is not given before; relative, 0.02 …
// 0.3; far from slip also a margin with this standard deviation is. Too small: margins after a change stay
// low, and only heavy loads are answered. Too large: margins are too safe, and light torques are answered by
// a peak below the plateau.
inline constexpr double kSettledFriction = 0.08;

// How well a friction is known that was given, or that a slide shows; standard deviation of log mu, 0.01 …
// 0.3. |Q|/P of real slides scatters by 0.04 to 0.07. Too small: a given value that is wrong is believed
// against the frames, and a slide's noise is taken for friction. Too large: both say little.
inline constexpr double kKnownFrictionSpread = 0.05;

struct FrictionPriorOptions {
  // Beyond a scene's range the prior falls as a Gaussian of this standard deviation in log mu; dimensionless,
  // 0.01 … 1. Too small: an object somewhat outside the range is never learnt. Too large: the range says
  // nothing where the frames leave friction open.
  double scene_spread = 0.15;
};

struct FrictionPrior {
  // mu that is expected, low > 0; both ends equal where one value was given.
  Range expected;
  // Standard deviation of log mu beyond the range; dimensionless, > 0.
  double spread = FrictionPriorOptions{}.scene_spread;

  // Minus the logarithm of the prior at mu > 0, in nats, 0 within the range.
  double nats_against(double mu) const noexcept {
    const double beyond = std::max({0.0, std::log(mu / expected.high), std::log(expected.low / mu)});
    const double sigmas = beyond / spread;
    return 0.5 * sigmas * sigmas;
  }

  // What a measured friction and this prior say together: the most likely mu, > 0, and what speaks against
  // it, nats.
  struct Weighed {
    double mu = 0, nats = 0;
  };
  // measured: mu by a measurement alone, also 0 or less, where noise is larger than the load. information: of
  // that measurement, 1 over its variance, > 0. What it says against 0 and below is not counted.
  Weighed weigh(double measured, double information) const noexcept {
    const double nearest = std::clamp(measured, expected.low, expected.high);
    if (nearest == measured) return {measured, 0};
    const auto against = [information](double off) { return 0.5 * information * off * off; };
    // Two parabolas, the measurement's about its value and the prior's about the range.
    const double to_range = against(nearest - measured);
    if (!(measured > 0)) return {nearest, to_range - against(measured)};
    const double stay = nats_against(measured), part = stay / (stay + to_range);
    return {measured + part * (nearest - measured), part * to_range};
  }
};

}  // namespace slipd
