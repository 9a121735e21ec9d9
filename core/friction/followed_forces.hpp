// The forces of a grasp as the Winkler foundations get them: shear signed along one axis, and noise taken
// out, since a force that only trembles would be a reversal a frame (docs/theory.md §4): it is averaged while
// the load is steady, and what is left of it has a dead band. Estimate thread; plain state, nothing
// allocates.
#pragma once

#include "core/load/load_path.hpp"
#include "core/load/steady_load.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

// Sigmas are standard deviations of a force's noise in the same frame. Checked with `slipd-lab histories
// --grasps 400`.
struct FollowedForcesOptions {
  // Half-width of the dead band of P beyond the noise that is left, of the normal force, dimensionless, 1e-4
  // … 0.05: the band of a sensor without noise. No less than this is followed, so that the contact stays open
  // while the band is wider than the force. Too small: rounding is followed. Too large: small changes of load
  // are missed.
  double band_share = 0.002;
  // The same added to the band of shear, as a share of what is added for the normal force; 0 … 1. Shear is
  // smaller than the normal force: too large, and the band hides what slips.
  double shear_band_share = 0.1;
  // The axis is taken anew from shear this much larger than the one it was taken from; ratio, 1 … 3. Too
  // small: the axis turns with noise each frame. Too large: an early, noisy axis stays.
  double reaim_ratio = 1.5;
};

// The line that shear is signed along.
class ShearAxis {
 public:
  // Takes the axis anew where this frame knows it better. True if shear has turned out of a sure axis.
  bool aim(const ContactPatch& patch, double reaim_ratio) noexcept;

  // A frame's shear along it, N.
  double along_n(const ContactForces& forces) const noexcept {
    return forces.shear_x_n * x_ + forces.shear_y_n * y_;
  }
  // Cosine between a frame's shear and the axis, -1 … 1: the sign of the shear, or less where noise turns it.
  double cosine(const ContactPatch& patch) const noexcept {
    return patch.direction_x * x_ + patch.direction_y * y_;
  }

 private:
  double x_ = 0, y_ = 0;  // unit vector; 0 before the first shear
  double aimed_n_ = 0;    // the shear that it was taken from
};

// P >= 0 and Q along the axis, N.
struct SignedLoad {
  double normal_n = 0, shear_n = 0;
};

class FollowedForces {
 public:
  explicit FollowedForces(const FollowedForcesOptions& options = {}) noexcept : options_(options) {}

  void reset() noexcept { *this = FollowedForces(options_); }

  // First call for each frame. True if shear has turned: what is followed then begins anew along the new
  // axis.
  bool aim(const ContactPatch& patch) noexcept { return axis_.aim(patch, options_.reaim_ratio); }

  // Second call for each frame: where the load goes to that was followed to `from`. A force changes when it
  // leaves its dead band.
  SignedLoad follow(const ContactPatch& patch, const SignedLoad& from) noexcept;
  // The load of that frame, without its noise.
  const SteadyLoad& steady() const noexcept { return steady_; }

  // Third call for each frame. True for the one frame, if any, at which it is clear that the grasp began
  // before its first frame.
  bool loaded_at_onset(const ContactPatch& patch) noexcept;

  const ShearAxis& axis() const noexcept { return axis_; }

 private:
  FollowedForcesOptions options_;
  ShearAxis axis_;
  SteadyLoad steady_;
  std::uint32_t frames_ = 0;  // of this grasp, up to kSureFrames
  double first_normal_n_ = 0;
};

}  // namespace slipd
