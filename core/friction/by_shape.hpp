// Friction where frames have a shape. Each friction of the grid follows the grasp's forces with a Winkler
// foundation of its own. A frame takes weight from those whose contact would look otherwise by now, after a
// regrip, an unloading or a reversal just as after a monotonic load (docs/methods.md §28). Estimate thread;
// fixed memory, nothing allocates.
#pragma once

#include "core/friction/followed_forces.hpp"
#include "core/friction/friction_filter.hpp"
#include "core/friction/winkler_foundations.hpp"

namespace slipd {

class FrictionByShape final : public FrictionFilter {
 public:
  explicit FrictionByShape(const FrictionPrior& prior, const FrictionFilterOptions& options = {});

  // The foundations know pulls only: where a torque has changed the field they rest, and start anew
  // afterwards.
  void update(const FrictionFrame& frame) noexcept override;
  void reset() noexcept override;
  // The history is assumed until frames confirm it.
  void lose_sight() noexcept override;

  MeanSigma margin_offset() const noexcept override { return grasp_.margin_offset; }
  bool doubted() const noexcept override { return grasp_.doubt_frames > 0; }
  bool explained() const noexcept override {
    return !grasp_.shear_lost && grasp_.unverified_frames <= options_.max_unverified_frames;
  }
  bool shear_lost() const noexcept override { return grasp_.shear_lost; }
  bool fallen() const noexcept override { return grasp_.fallen; }
  bool understood() const noexcept override {
    return (grasp_.turning || is_known(history())) && evidence_.mean_residual < options_.max_mean_residual;
  }

 protected:
  void lose_history(HistoryEvent why) noexcept override;

 private:
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
  };

  // What a new grasp forgets.
  struct GraspState {
    bool turning = false;     // the last frame's shear was changed by a torque
    int doubt_frames = 0;     // to come
    MeanSigma margin_offset;  // see margin_offset()
    double likeliest = 0;     // friction a frame ago; 0 before the first
    SlipMoment slip_moment;
    // The most, since the load was last monotonic, of what taxels make of shear moments, N.
    contact::ShearMoments locked_in_sigma;
    bool fallen = false;         // see fallen()
    bool other_history = false;  // the load was not monotonic once
    MomentResiduals moment_residuals;
    bool last_clear = false;    // the last frame's shear was far above its noise
    bool shear_lost = false;    // shear fell to noise in one step
    int unverified_frames = 0;  // frames in a row with a clear shear that said nothing of friction
  };

  void follow(const ContactPatch& patch) noexcept;
  bool looks_monotonic(double normal_n, double load) noexcept;
  // True if the frame said something of friction.
  bool weigh_torque(const ContactPatch& patch, const Reading& reading) noexcept;
  bool weigh_frame(const FrictionFrame& frame) noexcept;
  // Squared residuals of each friction: of the frame's margin, of its shear moments.
  void compare_margin(const ContactPatch& patch, const Reading& reading,
                      PerFriction& residuals) const noexcept;
  void compare_moments(const ContactPatch& patch, const Reading& reading, PerFriction& residuals) noexcept;
  contact::ShearMoments with_locked_in(const Reading& reading) const noexcept;
  void doubt_likeliest(const Reading& reading, double sign, double open_n) noexcept;
  double share_of_moments(const ContactPatch& patch, const Reading& reading) noexcept;
  void detect_fall(const FrictionFrame& frame) noexcept;
  MeanSigma offset_of(std::size_t friction, double load, double normal_n) const noexcept;
  void doubt_jump() noexcept;
  void verify(const FrictionFrame& frame, bool clear) noexcept;

  FollowedForces forces_;
  WinklerFoundations foundations_;
  GraspState grasp_;
};

}  // namespace slipd
