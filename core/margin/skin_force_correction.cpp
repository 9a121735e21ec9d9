#include "core/margin/skin_force_correction.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {

ContactPatch SkinForceCorrection::of(const ContactPatch& patch, const ContactPatch& loaded,
                                     const Reading& reading, Estimate& out) noexcept {
  if (!under_skin_) share_.reset();
  const bool shown = reading.normal_n > 0 && reading.shear_n > 0 && patch.normal_n > 0 && patch.shear_n > 0;
  if (shown && (under_skin_ || reading.in_model)) {
    const Share now{reading.normal_n / patch.normal_n, reading.shear_n / patch.shear_n};
    if (!share_) share_ = now;
    share_->normal += kGain * (now.normal - share_->normal);
    share_->shear += kGain * (now.shear - share_->shear);
  }
  ContactPatch acting = loaded;
  if (!share_) return acting;
  acting.normal_n *= share_->normal;
  acting.normal_sigma_n *= share_->normal;
  acting.shear_n *= share_->shear;
  acting.shear_x_n *= share_->shear;
  acting.shear_y_n *= share_->shear;
  acting.shear_sigma_n *= share_->shear;
  out.normal_n = acting.normal_n;
  out.shear_n = share_->shear * patch.shear_n;
  out.shear_x_n = share_->shear * patch.shear_x_n;
  out.shear_y_n = share_->shear * patch.shear_y_n;
  return acting;
}

ContactPatch SkinForceCorrection::of_pad(const std::optional<PadForces::Forces>& forces,
                                         const ContactPatch& patch, const ContactPatch& loaded,
                                         Estimate& out) noexcept {
  ContactPatch acting = loaded;
  share_.reset();
  if (!forces) return acting;
  share_ = Share{};  // of forces that are known
  acting.normal_n = forces->normal_n;
  acting.shear_x_n = forces->shear_x_n;
  acting.shear_y_n = forces->shear_y_n;
  out.normal_n = forces->normal_n;
  out.shear_x_n = forces->shear_x_n;
  out.shear_y_n = forces->shear_y_n;
  out.shear_n = std::hypot(forces->shear_x_n, forces->shear_y_n);
  // Of a torque's shear as much is missed as of a pull's.
  const double by_torque_n = std::max(0.0, loaded.shear_n - patch.shear_n) / forces->read;
  acting.shear_n = *out.shear_n + by_torque_n;
  out.pull_n = acting.shear_n;
  acting.normal_sigma_n = forces->normal_sigma_n;
  acting.shear_sigma_n = std::max(forces->shear_sigma_n, loaded.shear_sigma_n / forces->read);
  return acting;
}

}  // namespace slipd
