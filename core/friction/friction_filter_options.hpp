// Every threshold of FrictionFilter (docs/methods.md §28).
#pragma once
#include <cstddef>
#include <cstdlib>

#include "core/friction/followed_forces.hpp"
#include "core/friction/friction_posterior.hpp"
#include "core/friction/history_state.hpp"
#include "core/friction/traction_ratio.hpp"

namespace slipd {

// Sigmas are standard deviations of a force's noise in the same frame. A residual is what a frame shows less
// what a friction expects of it; squared residuals are in units of their variance. Shares are dimensionless.
// Checked with `slipd-lab histories --grasps 400`; fields of force-only sensors with `slipd-lab tradeoff
// --layouts 4,wrench`, rows over time.
struct FrictionFilterOptions {
  FrictionPosteriorOptions posterior;
  TractionRatioOptions traction_ratio;
  FollowedForcesOptions forces;
  HistoryOptions history;

  // Points of the grid where frames have a shape, each with a Winkler foundation of its own; 16 …
  // WinklerFoundations::kMost. Too few: the right friction lies between two. More cost time in proportion.
  std::size_t foundations = 56;
  // As FrictionPosteriorOptions::falls_per_s and rises_per_s, of a force-only sensor, whose frames hardly
  // show a change: more often, and what a slide has shown is forgotten before the next; 1/s, 0.01 … 1.
  double force_only_changes_per_s = 0.2;
  // Of a force-only sensor, which has none: friction known by a slide would change in steps.
  std::size_t force_only_points() const noexcept { return 2 * foundations; }

  // Sigma of a frame's margin up to which it confirms that a load which was not seen was monotonic; Gamma,
  // 0.05 … 0.5. Too small: such a grasp gets no margin while its load is light. Too large: frames whose noise
  // some friction always explains confirm a history that is wrong.
  double confirming_sigma = 0.2;

  // How fast a load is let go, in friction limits a second, and in what share of all frames it is; 0.5 … 50
  // and 0.01 … 1. One that falls faster between two frames may be one that friction no longer holds. Too
  // small: an object that is set down fast leaves friction open. Too large: friction that fell between two
  // frames leaves margins that are too safe.
  double unload_per_s = 3;
  double unload_share = 0.1;

  // What frames have in common of the error of a margin profile, of its noise; standard deviations, 0.01 … 1.
  // Too small: sigma is less than the error. Too large: learns slowly.
  double profile_common_share = 0.1;

  // How far the slip moment of the likeliest friction's foundation may be from a monotonic load's and still
  // count as one: a share of Q, plus a share of mu P; 0.01 … 0.1 and 0.001 … 0.01. Too small: a monotonic
  // load counts as a general one, and frames by themselves say nothing. Too large: traction of a small
  // unloading is overlooked.
  double monotonic_share_of_shear = 0.03;
  double monotonic_share_of_limit = 0.003;

  // Standard deviation of what such a load adds to a frame's margin, of that; 0 … 1. Methods differ in how
  // much of it they read. Too small: sigma is less than the error after a small regrip or unloading. Too
  // large: frames that say much are wasted.
  double offset_sigma_share = 0.3;

  // How well noisy forces reproduce the locked-in traction, of the larger shear moment; the same, 0 … 0.2.
  // Too small and too large: as above, after an unloading.
  double locked_in_share = 0.04;

  // Mean of least squared residuals from which no margin is given; 1.2 … 9, below 1 where all is understood.
  double max_mean_residual = 2;
};

}  // namespace slipd
