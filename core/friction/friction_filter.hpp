// Friction of one grasp: a Bayes filter on a grid of log mu (docs/theory.md §11). Each
// friction of the grid follows the grasp's forces with a Winkler foundation of its own. A frame takes weight
// from those whose contact would look otherwise by now, after a regrip, an unloading or a reversal just as
// after a monotonic load. What no frame distinguishes stays open: a contact that sticks all over looks the
// same for every friction that holds it.
//
// A change of friction is learnt within a few frames, and sooner if it fell than if it rose. Estimate thread;
// fixed memory, nothing allocates.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/friction/followed_forces.hpp"
#include "core/friction/friction_filter_options.hpp"
#include "core/friction/friction_grid.hpp"
#include "core/friction/history_state.hpp"
#include "core/friction/traction_ratio.hpp"
#include "core/friction/winkler_foundations.hpp"
#include "core/reading/method/friction_prior.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

class FrictionFilter {
 public:
  // force_only: frames of this sensor say little of their own. Then there are no foundations, and gross slip
  // is read from |Q|/P, which stays even while P falls.
  FrictionFilter(const FrictionPrior& prior, bool force_only, const FrictionFilterOptions& options = {});

  // A new grasp: back to the prior.
  void reset() noexcept;

  // One frame in contact, in order of time. `reading` is null where the frame has no shape. Where a
  // torque has bent the field (reading->turning) shear_n of `patch` is the pull that asks for as much
  // of friction; the foundations, which know pulls only, rest meanwhile, and start anew afterwards. `course`:
  // what is known of sliding, at most a frame old.
  void update(std::int64_t time_ns, const ContactPatch& patch, const Reading* reading,
              const SlidingVerdict& course = {}) noexcept;

  // The posterior of friction.
  const FrictionGrid& grid() const noexcept { return grid_; }

  // |Q|/P now: of force-only sensors what the last few frames say of it.
  const MeanSigma& traction_ratio() const noexcept { return traction_ratio_.now(); }

  // What is known of the load before this frame.
  HistoryState history() const noexcept { return history_.state(); }

  // What a frame's margin, read as one of a monotonic load, misses by the history that the likeliest
  // friction's contact has had: to be added to it, Gamma; and its standard deviation.
  const MeanSigma& margin_offset() const noexcept { return grasp_.margin_offset; }

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
  // A clear shear vanished from one frame to the next, by more than an unloading explains.
  bool shear_lost() const noexcept { return grasp_.shear_lost; }
  // Friction has fallen in this grasp, as far as frames then left it open.
  bool fallen() const noexcept { return grasp_.fallen; }

  // The history is known, and frames of late look as some friction would make them.
  bool understood() const noexcept {
    return (grasp_.turning || is_known(history())) && grasp_.mean_residual < options_.max_mean_residual;
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

  // Frames of one contact share a part of their error (docs/theory.md §11.2): what n of them say of friction
  // has the variance common^2 + noise^2/n, relative to friction.
  struct CommonError {
    // What the frames so far said, as the inverse of that variance; faded as the contact changes.
    double known = 0;
    double mean = 0;  // of the common sigma over the frames so far; 0: none yet
    // That mean before this frame, of which `sigma` is the common sigma. A frame's own would be larger or
    // smaller with its noise, and so would its weight.
    double usual(double sigma, double gain) noexcept {
      const double before = mean > 0 ? mean : sigma;
      mean = before + gain * (sigma - before);
      return before;
    }
    // Adds a frame of variances `common` and `noise` > 0. Returns how much of its evidence is new, 0 … 1.
    double add(double common, double noise) noexcept {
      const double open = 1 / std::max(known, kLeast) - common;
      if (!(open > 0)) return 0;
      const double with_it = 1 / (common + 1 / (1 / open + 1 / noise)),
                   share = (with_it - known) * (common + noise);
      known = with_it;
      return std::clamp(share, 0.0, 1.0);
    }
    static constexpr double kLeast = 1e-9;  // of known: nothing was said
  };

  // Mean residuals of the likeliest friction's foundation, N.
  struct MomentResiduals {
    double slip_moment_n = 0;
    double second_legendre_n = 0;
  };

  // The slip moment of the last frame, N, signed like Q.
  struct SlipMoment {
    bool known = false;
    std::size_t friction = 0;           // the likeliest then
    double seen_n = 0, expected_n = 0;  // of the frame, of that friction's foundation
    double sigma_n = 0;                 // of noise
    double normal_n = 0, shear_n = 0;   // forces then
  };

  // What a new grasp forgets.
  struct GraspState {
    double lighter_n = 0;  // P that the evidence of forces alone stands for; 0: none yet
    bool surprised = false;
    bool hooked = false;       // the load exceeded any friction, and has not fallen below all of them since
    bool turning = false;      // the last frame's shear was bent by a torque
    int doubt_frames = 0;      // to come
    MeanSigma margin_offset;   // see margin_offset()
    double likeliest = 0;      // friction a frame ago; 0 before the first
    double mean_residual = 1;  // of the best friction, squared
    Cusum cusum;
    EvidenceDiscount discount;
    CommonError of_margins, of_moments;
    SlipMoment slip_moment;
    // The most, since the load was last monotonic, of what taxels make of shear moments, N.
    contact::ShearMoments locked_in_sigma;
    bool fallen = false;                                 // see fallen()
    bool other_history = false;                          // the load was not monotonic once
    double evidence_normal_n = 0, evidence_shear_n = 0;  // forces of the last frame that was weighed
    MomentResiduals moment_residuals;
    std::int64_t last_ns = 0;                       // time of the frame before; 0 before the first
    double last_shear_x_n = 0, last_shear_y_n = 0;  // of the frame before
    bool last_clear = false;                        // the last frame's shear was far above its noise
    bool shear_lost = false;                        // shear fell to noise in one step
    int unverified_frames = 0;  // frames in a row with a clear shear that said nothing of friction
  };

  void fade(std::int64_t time_ns) noexcept;
  // The frames before say nothing of what the next ones have in common.
  void forget_common() noexcept {
    grasp_.discount = {};
    grasp_.of_margins.known = grasp_.of_moments.known = 0;
  }
  void watch_hook() noexcept;
  void bound_below() noexcept;
  void follow(const ContactPatch& patch) noexcept;
  bool weigh_turning(const ContactPatch& patch, const Reading& reading) noexcept;
  void lose_history(HistoryEvent why) noexcept;
  bool looks_monotonic(double normal_n, double load) noexcept;
  // True if the frame said something of friction.
  bool weigh_frame(const ContactPatch& patch, const Reading& reading) noexcept;
  // Squared residuals of each friction: of the frame's margin, of its shear moments.
  void compare_margin(const ContactPatch& patch, const Reading& reading,
                      PerFriction& residuals) const noexcept;
  void compare_moments(const ContactPatch& patch, const Reading& reading, PerFriction& residuals) noexcept;
  contact::ShearMoments with_locked_in(const Reading& reading) const noexcept;
  void doubt_likeliest(const Reading& reading, double sign, double open_n) noexcept;
  // False if no friction explains the frame.
  bool take_evidence(const PerFriction& residuals, bool confirms_monotonic, double share) noexcept;
  void part_errors(const ContactPatch& patch) noexcept;
  double share_of_margin(double load, const Reading& reading) noexcept;
  double share_of_moments(const ContactPatch& patch, const Reading& reading) noexcept;
  void detect_fall(const ContactPatch& patch, const Reading& reading) noexcept;
  MeanSigma offset_of(std::size_t friction, double load, double normal_n) const noexcept;
  void doubt_jump() noexcept;
  void verify(const ContactPatch& patch, bool clear) noexcept;
  void weigh_slide(const TractionRatioFilter::Slide& slide) noexcept;
  void forget_lighter(const ContactPatch& patch) noexcept;

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
