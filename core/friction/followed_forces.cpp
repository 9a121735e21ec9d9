#include "core/friction/followed_forces.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/significance.hpp"
#include "core/health/usual.hpp"
#include "core/load/load_path.hpp"

namespace slipd {
namespace {

// Backlash: `from` moves only as far as keeps `to` within the band about it.
double drag(double from, double to, double band) noexcept {
  if (to > from + band) return to - band;
  if (to < from - band) return to + band;
  return from;
}

}  // namespace

// The direction of shear is the surer the more of it there is: until it is clear the axis follows each frame,
// later with each growth by reaim_ratio.
bool ShearAxis::aim(const ContactPatch& patch, double reaim_ratio) noexcept {
  const double clear_n = kStrongSigmas * patch.shear_sigma_n;
  const double across_n = std::fabs(patch.shear_y_n * x_ - patch.shear_x_n * y_);
  const bool turned = across_n > clear_n && across_n > kTurned * patch.shear_n;
  const double reaim_n = std::max(reaim_ratio * aimed_n_, kClearSigmas * patch.shear_sigma_n);
  if (!(patch.shear_n > reaim_n || aimed_n_ < clear_n || turned)) return false;
  const bool reversed = cosine(patch) < 0 && !turned;
  x_ = reversed ? -patch.direction_x : patch.direction_x;
  y_ = reversed ? -patch.direction_y : patch.direction_y;
  const bool was_sure = aimed_n_ > clear_n;
  aimed_n_ = patch.shear_n;
  return turned && was_sure;
}

SignedLoad FollowedForces::follow(const ContactPatch& patch, const SignedLoad& from) noexcept {
  steady_.follow(forces_of(patch), patch.normal_sigma_n, patch.shear_sigma_n);
  const double noise = steady_.noise_share(), least_n = options_.band_share * patch.normal_n;
  const SignedLoad to{
      .normal_n = drag(from.normal_n, steady_.now().normal_n, noise * patch.normal_sigma_n + least_n),
      .shear_n = drag(from.shear_n, axis_.along_n(steady_.now()),
                      noise * patch.shear_sigma_n + options_.shear_band_share * least_n)};
  if (to.normal_n == from.normal_n && to.shear_n == from.shear_n) return from;
  return {std::max(to.normal_n, least_n), to.shear_n};
}

bool FollowedForces::loaded_at_onset(const ContactPatch& patch) noexcept {
  if (frames_ >= kSureFrames) return false;
  if (frames_++ == 0) first_normal_n_ = patch.normal_n;
  const bool loaded = patch.shear_n > kStrongSigmas * patch.shear_sigma_n;
  return frames_ == kSureFrames && loaded && kFallen * patch.normal_n < first_normal_n_;
}

}  // namespace slipd
