// Friction over time. After a monotonic load a frame determines its margin by itself; after a regrip, an
// unloading or a reversal only together with the friction and the forces of the frames before it, and the
// margin is 1 - |Q|/(mu P) (docs/theory.md §11).
#pragma once

#include <optional>

#include "core/contact/scene.hpp"
#include "core/estimate/estimate.hpp"
#include "core/estimate/settings.hpp"
#include "core/friction/friction_filter.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

// Checked with `sliplab histories --grasps 400`.
struct MarginFusionOptions {
  FrictionPriorOptions prior;
  FrictionFilterOptions filter;

  // How far the grid reaches beyond the range that was given, or that the scene expects: of sensors whose
  // frames have a shape, and of force-only ones; of log mu, 0.01 … 0.3. Friction itself is given within the
  // range. Too small: a friction at the range's end has no room for noise. Too large: the range is no bound.
  double shaped_slack = 0.1;
  double force_only_slack = 0.02;

  // Friction whose sigma is below this is given with an estimate; relative, 0.05 … 1. Too small: grip advice
  // comes late. Too large: it is advice from a guess.
  double known_sigma = 0.3;
  // The same for friction under torque; relative, 0.03 … 0.3. Too small: friction lags
  // behind the frames. Too large: friction is given that is off by more than a tenth.
  double frame_known_sigma = 0.1;
  // Memory of friction gives margins under a torque if its sigma is below this; relative, 0.1 … 0.4. Too
  // small: loads that rise get no margin before taxels slip. Too large: friction that a light pull has shown
  // gives heavier loads margins that are too safe.
  double turning_known_sigma = 0.18;
  // Friction is learnt when frames have left less than this of the prior's relative sigma; 0.1 … 0.95. Too
  // small: friction is given late. Too large: the prior is given for friction.
  double learnt_share = 0.6;
  // Forces alone leave the margin anywhere between what both ends of friction's range make of them. Of a
  // range up to this wide, log of its ends' ratio, 0 … 3, less than a sigma is taken off its mean where
  // sigma_max demands it. Too small: a known range is of no use. Too large: margins of objects of any kind
  // are given from next to nothing.
  double narrow_range = 1.5;
  // Friction that has fallen is open until its sigma is below this; relative, 0.02 … 0.3. Until then the
  // lower part of its posterior is given, one sigma down. Too small: margins after a fall stay low. Too
  // large: they are too safe.
  double settled_sigma = 0.05;
  // Floor of a margin's sigma while friction is doubted; Gamma, 0.05 … 1; above sigma_max no margin is given
  // at all. Too small: a margin of a friction that has fallen is given as sure. Too large: no effect beyond
  // sigma_max.
  double doubted_sigma = 0.2;
  // Standard deviation of a margin by memory under a torque whose load has fallen, of the range between it
  // and what friction would leave that is just as high as the ratios that taxels carry; 0 … 0.3. Too small:
  // friction that falls between two peaks of the load leaves margins that are given as sure. Too large:
  // cycles lose their margin at each trough.
  double unseen_fall_share = 0.15;
  // Floor of every margin's sigma; Gamma, 1e-6 … 0.01: what the contact model itself leaves on a perfect
  // sensor (the mean error of `fit` on 100 x 100 taxels with 1 % of relative noise is 0.0002). Too small: a
  // margin of a frame without noise is given as exact. Too large: sharp frames are wasted.
  double least_sigma = 5e-4;
  // The same where at most kFewTaxels taxels feel a curved contact; Gamma, 0.005 … 0.05.
  double few_taxels_sigma = 0.03;
  // Floor of the sigma of friction over a grasp, relative, in a margin that is computed from it; 0 … 0.1: the
  // contact that is followed has errors that all frames share. A frame's own sharper margin is not concerned.
  // Too small: sigma is less than the error after a regrip, an unloading or a hold. Too large: margins of
  // these are less sharp than they could be. `sliplab coverage --grasps 40 --of histories`.
  double least_friction_sigma = 0.03;
  // A frame's own margin replaces the filter's if both agree within this; standard deviations of their
  // difference, 1 … 5. Too small: good frames are wasted. Too large: a frame of another history is given.
  double agreement_sigmas = 2.5;
};

class MarginFusion {
 public:
  // friction_expected: the scene's range. friction: known beforehand, instead of it, and a hard bound; so is
  // the scene's range where frames show no friction by themselves. force_only: no single frame of this sensor
  // determines its margin.
  MarginFusion(const EstimatorSettings& settings, Range friction_expected,
               std::optional<KnownFriction> friction, bool force_only,
               const MarginFusionOptions& options = {});

  // Estimate thread. Fills in state, gamma, sigma, friction and method of `out`, whose forces and sequence
  // are set. `reading` is null where the sensor has no method of its own (one force vector, flat
  // skin), or the frame no shear. `course`: what is known of sliding, at most a frame old. `shared`: what
  // this frame of a flat skin shows of the margin (core/friction/pad_load_sharing.hpp); null: nothing.
  void update(const ContactPatch& patch, const Reading* reading, Method method, Estimate& out,
              const SlidingVerdict& course = {}, const MarginProfile* shared = nullptr) noexcept;

  // As learnt in this grasp so far, or as given or expected.
  double friction() const noexcept { return last_friction_; }

  // The contact was lost: what was learnt of this object is forgotten.
  void forget() noexcept {
    friction_filter_.reset();
    last_friction_ = prior_.mean;
  }

 private:
  // The margin by all frames up to this one; nullopt if they contradict every friction.
  std::optional<MeanSigma> track(const ContactPatch& patch, const Reading* reading, Method method,
                                 const SlidingVerdict& course, const MarginProfile* shared,
                                 Estimate& out) noexcept;
  // The filter's margin at |Q|/P = load, or the lower one that the frame shows.
  MeanSigma margin_at(double load, double load_sigma, const MarginProfile* shared) const noexcept;
  // The filter's margin, or the frame's own where that is the better one.
  MeanSigma combine(MeanSigma margin, const Reading& reading, Method method, Estimate& out) const noexcept;

  // Frames of late contradict what is known of friction; a value that was given is not doubted.
  bool doubted() const noexcept { return !given_value_ && friction_filter_.doubted(); }
  // Adds to sigma what friction may have fallen by unseen. `load`: |Q|/P; a margin of a given value stays.
  void widen_by_unseen_fall(double load, const Reading& reading, MeanSigma& margin) const noexcept;
  // What forces alone leave of the margin, on the safe side of its middle.
  MeanSigma lowered(MeanSigma margin) const noexcept;
  // `lowered`, or where that is too wide and the bounds of friction leave `margin` near 0 all the same, a low
  // margin. `load`: |Q|/P.
  MeanSigma within_bounds(MeanSigma lowered, MeanSigma margin, double load) const noexcept;
  void give_friction(Estimate& out) const noexcept;
  void give_limit(const ContactPatch& patch, Estimate& out) const noexcept;

  EstimatorSettings settings_;
  bool force_only_;
  KnownFriction friction_;  // given, else expected
  bool given_value_;
  std::optional<Range> bounds_;  // of what is learnt
  MarginFusionOptions options_;
  FrictionFilter friction_filter_;
  MeanSigma prior_;       // of friction
  double last_friction_;  // its mean a frame ago
};

}  // namespace slipd
