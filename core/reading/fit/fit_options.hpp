// How the contact model is fitted to taxels: what Fit and SubsurfaceFit share.
#pragma once

#include <algorithm>

#include "core/reading/method/friction_prior.hpp"
#include "core/reading/moments/moments.hpp"

namespace slipd {

// Dimensionless unless a unit is given. Checked with `slipd-lab tradeoff --no-models`, rows of fit: sigma is
// right where 68 % of the answers are within it; those of a real skin with `slipd-lab stability --parts
// adversary`. peak: a Hertz contact's largest pressure p0.
struct FitOptions {
  MomentRatioOptions ratio;
  FrictionPriorOptions prior;

  // The taxels of a grid are summed in square blocks, so many along the contact's radius or up to twice as
  // many (SquareBlocks); 6 … 16; 0: each taxel by itself. Too small: margins are less exact. Too large: costs
  // time.
  double blocks_along_radius = 0;
  // The same of the blocks on which such a fit takes all steps but the last one; 3 … 6. Too small: the last
  // step starts far from the minimum. Too large: costs time.
  double first_blocks_along_radius = 4;
  // Range of Gamma within which the fit searches; 1e-9 … 0.01 and 0.99 … 1. Too wide: the normal equations
  // are singular at the ends. Too narrow: answers near the ends are drawn inwards.
  double min_gamma = 1e-6;
  double max_gamma = 1 - 1e-4;
  // It starts at least this far from no margin and from no load; Gamma, 0.01 … 0.2. Too small: it starts
  // where slopes vanish, and does not converge. Too large: more steps.
  double start_within = 0.05;
  double away_from_ends(double gamma) const noexcept {
    return std::clamp(gamma, start_within, 1 - start_within);
  }
  // The most by which one step may change the radius; factor, 1.1 … 10. Too small: more steps. Too large: a
  // wild step leaves the taxels.
  double max_radius_factor = 2;
  // Levenberg-Marquardt's damping at first and at least after a step that was refused, and the factor by
  // which it falls or grows; 1e-6 … 1, 2 … 100. Too small a first one: steps are refused. Too large: more
  // steps.
  double first_damping = 1e-3;
  double damping_factor = 10;
  // It has converged after a step shorter than this, in standard deviations; 1e-6 … 0.5. Too small: more
  // steps, for nothing. Too large: it stops before the minimum.
  double converged_sigmas = 0.1;

  // Ellipticity of the pressure (HertzDeviation) from which on an ellipse is fitted; 0.05 … 0.3. Too small:
  // costs time for nothing. Too large: ellipses are read as round contacts, and sigma does not cover it.
  double elliptic_from = 0.1;

  // Those of method `block-fit`.
  static FitOptions in_blocks() {
    FitOptions options;
    options.blocks_along_radius = 8;
    return options;
  }
};

}  // namespace slipd
