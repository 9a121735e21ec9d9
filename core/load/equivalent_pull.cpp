#include "core/load/equivalent_pull.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/few_taxels.hpp"
#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {

bool EquivalentPull::clear(const ContactPatch& patch) const noexcept {
  if (!(patch.radius_m > 0)) return false;
  const double torque_nm = std::fabs(patch.torque_nm), side = coarse(patch);
  const double least_share = kUnevenShare + kCoarseTorque * side * side;
  const double sigmas = outweighs(patch) ? kAlikeSigmas : kClearSigmas;
  return torque_nm > sigmas * patch.torque_sigma_nm &&
         torque_nm > least_share * patch.shear_n * patch.radius_m;
}

bool EquivalentPull::changes_shear(const ContactPatch& patch, bool changed) const noexcept {
  const double torque_nm = std::fabs(patch.torque_nm);
  return torque_nm > kChanged * patch.shear_n * patch.radius_m &&
         (changed || torque_nm > kStandsOutSigmas * patch.torque_sigma_nm);
}

EquivalentPullResult EquivalentPull::of(const ContactPatch& patch, TorqueEffect previous) noexcept {
  EquivalentPullResult out{.pull_n = patch.shear_n, .pull_sigma_n = patch.shear_sigma_n};
  const bool is_clear = clear(patch);
  if ((!is_clear && !outweighs(patch)) || !(patch.normal_n > 0) || !(patch.radius_m > 0)) return out;
  const contact::LeastFriction least = least_friction(patch);
  if (!is_clear) {
    // Noise may be all of the torque, and the torque may be all that the object carries.
    out.pull_sigma_n = norm(out.pull_sigma_n, std::max(0.0, least.ratio * patch.normal_n - patch.shear_n));
    return out;
  }
  out.torque_effect = changes_shear(patch, previous == TorqueEffect::changes_shear)
                          ? TorqueEffect::changes_shear
                          : TorqueEffect::light;
  // Never less than the pull alone, which rounding and noisy cells could make of a light torque.
  out.pull_n = std::max(patch.shear_n, least.ratio * patch.normal_n);
  const double by_noise_n = patch.normal_n * norm(least.per_shear_n * patch.shear_sigma_n,
                                                  least.per_torque_nm * patch.torque_sigma_nm);
  const double side = coarse(patch);
  out.pull_sigma_n = norm(
      by_noise_n, options_.coarse_sigma_share * std::min(1.0, side * side) * (out.pull_n - patch.shear_n));
  out.along_per_n = least.per_shear_n;
  out.spin_per_nm = std::copysign(least.per_torque_nm, patch.torque_nm);
  return out;
}

PullOfOneForce::PullOfOneForce(const EquivalentPullOptions& options)
    : EquivalentPull(0, options), unit_hertz_(contact::unit_hertz_surface()) {}

contact::LeastFriction PullOfOneForce::least_friction(const ContactPatch& patch) noexcept {
  const double lever_m = patch.radius_m;
  contact::LeastFriction least =
      unit_hertz_.least_friction(patch.shear_x_n / patch.normal_n, patch.shear_y_n / patch.normal_n,
                                 patch.torque_nm / (patch.normal_n * lever_m));
  least.per_shear_n /= patch.normal_n;
  least.per_torque_nm /= patch.normal_n * lever_m;
  return least;
}

PullOfTaxels::PullOfTaxels(const TaxelLayout& layout, const EquivalentPullOptions& options)
    : EquivalentPull(layout.side_m(), options), cells_(layout) {}

contact::LeastFriction PullOfTaxels::least_friction(const ContactPatch& patch) noexcept {
  const contact::LimitSurface& surface = cells_.pool(patch);
  const double side = coarse(patch), within = cells_.are_taxels() ? options_.within_taxels : 0;
  return surface.least_friction(patch.shear_x_n, patch.shear_y_n,
                                (1 + within * side * side) * patch.torque_nm);
}

bool PullOfFewTaxels::outweighs(const ContactPatch& patch) const noexcept {
  return std::fabs(patch.torque_nm) > options_.outweighing_share * patch.shear_n * patch.radius_m;
}

std::unique_ptr<EquivalentPull> make_equivalent_pull(const TaxelLayout& layout,
                                                     const EquivalentPullOptions& options) {
  if (layout.size() == 1) return std::make_unique<PullOfOneForce>(options);
  if (layout.size() <= kFewTaxels) return std::make_unique<PullOfFewTaxels>(layout, options);
  return std::make_unique<PullOfTaxels>(layout, options);
}

}  // namespace slipd
