#include "core/margin/surface_load.hpp"

#include <algorithm>
#include <cmath>

#include "core/numeric/norm.hpp"
#include "core/numeric/running_mean.hpp"

namespace slipd {
namespace {

// Whether the reading knows forces that the patch's disc reads a part of.
bool shows_forces(const ContactPatch& patch, const Reading& reading) noexcept {
  return reading.normal_n > 0 && reading.shear_n > 0 && patch.normal_n > 0 && patch.shear_n > 0;
}

ContactPatch scaled(const ContactPatch& pull, double normal, double shear) noexcept {
  ContactPatch acting = pull;
  acting.normal_n *= normal;
  acting.normal_sigma_n *= normal;
  acting.shear_n *= shear;
  acting.shear_x_n *= shear;
  acting.shear_y_n *= shear;
  acting.shear_sigma_n *= shear;
  return acting;
}

void publish(const ContactPatch& patch, double normal, double shear, Estimate& out) noexcept {
  out.normal_n = normal * patch.normal_n;
  out.shear_n = shear * patch.shear_n;
  out.shear_x_n = shear * patch.shear_x_n;
  out.shear_y_n = shear * patch.shear_y_n;
}

// The lower bound from the forces that act.
SurfaceLoad acting_load(const ContactPatch& acting) noexcept {
  SurfaceLoad load;
  load.acting = acting;
  load.normal_n = {acting.normal_n, acting.normal_sigma_n};
  load.shear_n = load.pull_n = {acting.shear_n, acting.shear_sigma_n};
  return load;
}

}  // namespace

SurfaceLoad measured_load(const ContactPatch& patch, const ContactPatch& pull) noexcept {
  SurfaceLoad load;
  load.acting = pull;
  load.normal_n = {patch.normal_n, patch.normal_sigma_n};
  load.shear_n = {patch.shear_n, patch.shear_sigma_n};
  load.pull_n = {pull.shear_n, pull.shear_sigma_n};
  return load;
}

SurfaceLoad ForcesAtSurface::of(const ContactPatch& patch, const ContactPatch& pull, const Reading& reading,
                                Estimate& out) noexcept {
  SurfaceLoad load = measured_load(patch, pull);
  if (!reading.in_model || !shows_forces(patch, reading)) return load;
  const double normal = reading.normal_n / patch.normal_n, shear = reading.shear_n / patch.shear_n;
  load.acting = scaled(pull, normal, shear);
  publish(patch, normal, shear, out);
  return load;
}

SurfaceLoad ForcesUnderSkin::of(const ContactPatch& patch, const ContactPatch& pull, const Reading& reading,
                                Estimate& out) noexcept {
  if (shows_forces(patch, reading)) {
    const Share now{reading.normal_n / patch.normal_n, reading.shear_n / patch.shear_n};
    if (!share_) share_ = now;
    share_->normal += kQuickGain * (now.normal - share_->normal);
    share_->shear += kQuickGain * (now.shear - share_->shear);
  }
  if (!share_) {
    SurfaceLoad load = measured_load(patch, pull);
    load.known = false;
    return load;
  }
  publish(patch, share_->normal, share_->shear, out);
  return acting_load(scaled(pull, share_->normal, share_->shear));
}

SurfaceLoad ForcesOfPad::of(const ContactPatch& patch, const ContactPatch& pull, const Reading& reading,
                            Estimate& out) noexcept {
  const auto forces = pad_.of(patch, reading);
  SurfaceLoad load = measured_load(patch, pull);
  if (forces) {
    ContactPatch acting = pull;
    out.normal_n = acting.normal_n = forces->normal_n;
    out.shear_x_n = acting.shear_x_n = forces->shear_x_n;
    out.shear_y_n = acting.shear_y_n = forces->shear_y_n;
    out.shear_n = norm(forces->shear_x_n, forces->shear_y_n);
    // Of a torque's shear as much is missed as of a pull's.
    const double by_torque_n = std::max(0.0, pull.shear_n - patch.shear_n) / forces->read;
    acting.shear_n = *out.shear_n + by_torque_n;
    out.pull_n = acting.shear_n;
    acting.normal_sigma_n = forces->normal_sigma_n;
    acting.shear_sigma_n = std::max(forces->shear_sigma_n, pull.shear_sigma_n / forces->read);
    load = acting_load(acting);
  }
  load.known = forces.has_value();
  load.common_sigma = common_sigma();
  return load;
}

}  // namespace slipd
