// Friction of one grasp: a Bayes filter on a grid of log mu (docs/theory.md §11). Each
// friction of the grid follows the grasp's forces with a Winkler foundation of its own. A frame takes weight
// from those whose contact would look otherwise by now, after a regrip, an unloading or a reversal just as
// after a monotonic load. What no frame tells apart stays open: a contact that sticks all over looks the same
// for every friction that holds it.
//
// A change of friction is learnt within a few frames, and sooner if it fell than if it rose. Estimate thread;
// fixed memory, nothing allocates.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/estimate/followed_forces.hpp"
#include "core/estimate/friction_filter_options.hpp"
#include "core/estimate/friction_grid.hpp"
#include "core/estimate/friction_prior.hpp"
#include "core/estimate/history_state.hpp"
#include "core/estimate/method.hpp"
#include "core/estimate/traction_ratio.hpp"
#include "core/estimate/winkler_foundations.hpp"

namespace slipd {

class FrictionFilter {
 public:
  // force_only: frames of this sensor say little of their own. Then there are no foundations, and gross slip
  // is read from |Q|/P, which stays even while P falls.
  FrictionFilter(const FrictionPrior& prior, bool force_only, const FrictionFilterOptions& options = {});

  // A new grasp: back to the prior.
  void reset() noexcept;

  // One frame in contact, in order of time. `frame_estimate` is null where the frame has no shape.
  void update(std::int64_t time_ns, const ContactPatch& patch, const FrameEstimate* frame_estimate) noexcept;

  // The posterior of friction.
  const FrictionGrid& grid() const noexcept { return grid_; }

  // |Q|/P now: of force-only sensors what the last few frames say of it.
  const MeanSigma& traction_ratio() const noexcept { return traction_ratio_.now(); }

  // What is known of the load before this frame.
  HistoryState history() const noexcept { return history_.state(); }

  // This frame contradicts the friction that was likeliest before it: friction has changed, or was wrong.
  bool surprised() const noexcept { return grasp_.surprised; }

  // Frames of late contradict it by less: friction is less than it was, and they do not say by how much.
  bool doubted() const noexcept { return grasp_.doubt_frames > 0; }

  // The course of the forces explains why frames say nothing of friction, if they say nothing: friction
  // learnt before may answer for them. Not so when shear was lost in one step, or when frames with a clear
  // shear have said nothing for long.
  bool explained() const noexcept {
    return !grasp_.shear_lost && grasp_.unverified_frames <= options_.max_unverified_frames;
  }

  // The history is known, and frames of late look as some friction would make them.
  bool understood() const noexcept {
    return is_known(history()) && grasp_.mean_residual < options_.max_mean_residual;
  }

 private:
  using PerFriction = std::array<double, FrictionGrid::kMost>;

  // Page's cumulative sum of evidence that friction has changed.
  struct Cusum {
    double nats = 0;
    void add(double evidence_nats, double drift_nats) noexcept {
      nats = std::max(0.0, nats + evidence_nats - drift_nats);
    }
  };

  // Evidence of margin profiles so far, in units of what all of them have in common.
  struct EvidenceDiscount {
    double common = 0;
    void add(double sigmas) noexcept { common += sigmas * sigmas; }
    double share() const noexcept { return 1 / (1 + common); }
  };

  // Mean residuals of the likeliest friction's foundation, N.
  struct MomentResiduals {
    double slip_moment_n = 0;
    double second_legendre_n = 0;
  };

  // What a new grasp forgets.
  struct GraspState {
    bool surprised = false;
    int doubt_frames = 0;      // to come
    double likeliest = 0;      // friction a frame ago; 0 before the first
    double mean_residual = 1;  // of the best friction, squared
    Cusum cusum;
    EvidenceDiscount discount;
    MomentResiduals moment_residuals;
    std::int64_t last_ns = 0;                       // time of the frame before; 0 before the first
    double last_shear_x_n = 0, last_shear_y_n = 0;  // of the frame before
    bool shear_lost = false;                        // shear fell to noise in one step
    int unverified_frames = 0;  // frames in a row with a clear shear that said nothing of friction
  };

  void fade(std::int64_t time_ns) noexcept;
  void bound_below() noexcept;
  void follow(const ContactPatch& patch) noexcept;
  void lose_history(HistoryEvent why) noexcept;
  bool looks_monotonic(double normal_n, double load) const noexcept;
  // True if the frame said something of friction.
  bool weigh_frame(const ContactPatch& patch, const FrameEstimate& frame_estimate) noexcept;
  // Squared residuals of each friction: of the frame's margin, of its shear moments.
  void compare_margin(double load, const FrameEstimate& frame_estimate,
                      PerFriction& residuals) const noexcept;
  void compare_moments(const ContactPatch& patch, const FrameEstimate& frame_estimate,
                       PerFriction& residuals) noexcept;
  void doubt_likeliest(const FrameEstimate& frame_estimate, double sign, double open_n) noexcept;
  // False if no friction explains the frame.
  bool take_evidence(const PerFriction& residuals, bool as_monotonic) noexcept;
  void doubt_jump() noexcept;
  void verify(const ContactPatch& patch, bool clear) noexcept;
  void weigh_slide(double load) noexcept;

  FrictionFilterOptions options_;
  bool force_only_;
  FrictionGrid grid_;
  TractionRatioFilter traction_ratio_;
  FollowedForces forces_;
  HistoryMonitor history_;
  WinklerFoundations foundations_;
  GraspState grasp_;
};

}  // namespace slipd
