// Friction over time. After a monotonic load a frame determines its margin by itself; after a regrip, an unloading
// or a reversal only together with the friction and the forces of the frames before it, and the margin is
// 1 - |Q|/(mu P) (docs/theory.md §11).
#pragma once

#include <optional>

#include "core/contact/scene.hpp"
#include "core/estimate/estimate.hpp"
#include "core/estimate/friction_filter.hpp"
#include "core/estimate/method.hpp"
#include "core/estimate/settings.hpp"

namespace slipd {

// Checked with `sliplab histories --grasps 400`.
struct TrackerOptions {
  FrictionPriorOptions prior;
  FrictionFilterOptions filter;

  // How far beyond the scene's range, or a given friction, a force-only sensor may learn; of log mu, 0.02 …
  // 0.5. Real slides scatter by 4 to 7 %. Too small: a friction at the range's end has no room for noise. Too
  // large: a relaxing grip passes for a slide.
  double bound_slack = 0.1;

  // Friction whose sigma is below this is given with an estimate; relative, 0.05 … 1. Too small: grip advice
  // comes late. Too large: it is advice from a guess.
  double known_sigma = 0.3;
  // Friction that has fallen is open until its sigma is below this; relative, 0.02 … 0.3. Until then the
  // lower part of its posterior is given, one sigma down. Too small: margins after a fall stay low. Too
  // large: they are too safe.
  double settled_sigma = 0.05;
  // Floor of a margin's sigma while friction is doubted; Gamma, 0.05 … 1; above sigma_max no margin is given
  // at all. Too small: a margin of a friction that has fallen is given as sure. Too large: no effect beyond
  // sigma_max.
  double doubted_sigma = 0.2;
  // Floor of every margin's sigma; Gamma, 1e-6 … 0.01: what the contact model itself leaves on a perfect
  // sensor (the mean error of `fit` on 100 x 100 taxels with 1 % of relative noise is 0.0002). Too small: a
  // margin of a frame without noise is given as exact. Too large: sharp frames are wasted.
  double least_sigma = 5e-4;
  // A frame's own margin replaces the filter's if both agree within this; standard deviations of their
  // difference, 1 … 5. Too small: good frames are wasted. Too large: a frame of another history is given.
  double agreement_sigmas = 2.5;
};

class Tracker {
 public:
  // friction_expected: the scene's range. friction: known beforehand. force_only: no single frame of this
  // sensor determines its margin.
  Tracker(const EstimatorSettings& settings, Range friction_expected, std::optional<double> friction,
          bool force_only, const TrackerOptions& options = {});

  // Estimate thread. Fills in state, gamma, sigma, friction and method of `out`, whose forces and sequence
  // are set. `frame_estimate` is null where the sensor has no method of its own (one force vector, flat
  // skin), or the frame no shear.
  void update(const ContactPatch& patch, const FrameEstimate* frame_estimate, Method method,
              Estimate& out) noexcept;

  // The contact was lost: what was learnt of this object is forgotten.
  void forget() noexcept { friction_filter_.reset(); }

 private:
  // The margin by all frames up to this one; nullopt if they contradict every friction.
  std::optional<MeanSigma> track(const ContactPatch& patch, const FrameEstimate* frame_estimate,
                                 Method method, Estimate& out) noexcept;
  // The filter's margin, or the frame's own where that is the better one.
  MeanSigma combine(MeanSigma margin, const FrameEstimate& frame_estimate, Method method,
                    Estimate& out) const noexcept;

  EstimatorSettings settings_;
  bool force_only_;
  TrackerOptions options_;
  FrictionFilter friction_filter_;
};

}  // namespace slipd
