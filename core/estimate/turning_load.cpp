#include "core/estimate/turning_load.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {

TurningLoad::TurningLoad(const TaxelLayout& layout, const TurningLoadOptions& options)
    : options_(options),
      cells_(layout),
      unit_hertz_(contact::unit_hertz_surface()),
      side_m_(layout.side_m()),
      one_taxel_(layout.size() == 1) {}

bool TurningLoad::clear(const ContactPatch& patch) const noexcept {
  if (!(patch.radius_m > 0)) return false;
  const double torque_nm = std::fabs(patch.torque_nm), coarse = one_taxel_ ? 0 : side_m_ / patch.radius_m;
  const double least_share = options_.least_share + options_.coarse_share * coarse * coarse;
  return torque_nm > options_.clear_sigmas * patch.torque_sigma_nm &&
         torque_nm > least_share * patch.shear_n * patch.radius_m;
}

void TurningLoad::follow(const ContactPatch& patch, TurningLoadResult& out) noexcept {
  constexpr double kSigmas = 2;  // what noise may be of the pull
  if (!(patch.normal_n > 0)) return;
  const double ratio = out.pull_n / patch.normal_n, noise = kSigmas * out.pull_sigma_n / patch.normal_n;
  out.risen = ratio + noise >= options_.risen_share * most_ratio_;
  if (ratio - noise <= most_ratio_ && patch.normal_n <= options_.regripped * most_normal_n_) return;
  most_ratio_ = std::max(0.0, ratio - noise);
  most_normal_n_ = patch.normal_n;
}

TurningLoadResult TurningLoad::of(const ContactPatch& patch) noexcept {
  TurningLoadResult out{.pull_n = patch.shear_n, .pull_sigma_n = patch.shear_sigma_n};
  if (!clear(patch) || !(patch.normal_n > 0)) {
    bent_ = false;
    follow(patch, out);
    return out;
  }
  contact::LeastFriction least;
  if (one_taxel_) {
    const double lever_m = patch.radius_m;
    least = unit_hertz_.least_friction(patch.shear_x_n / patch.normal_n, patch.shear_y_n / patch.normal_n,
                                       patch.torque_nm / (patch.normal_n * lever_m));
    least.per_shear_n /= patch.normal_n;
    least.per_torque_nm /= patch.normal_n * lever_m;
  } else {
    const contact::LimitSurface& surface = cells_.pool(patch);
    const double coarse = side_m_ / patch.radius_m;
    const double felt = cells_.are_taxels() ? 1 + options_.within_taxels * coarse * coarse : 1;
    least = surface.least_friction(patch.shear_x_n, patch.shear_y_n, felt * patch.torque_nm);
  }
  const double share = (bent_ ? options_.kept_share : 1) * options_.bending_share;
  bent_ = std::fabs(patch.torque_nm) > share * patch.shear_n * patch.radius_m &&
          (bent_ || std::fabs(patch.torque_nm) > options_.bending_sigmas * patch.torque_sigma_nm);
  out.turning = bent_ ? Turning::bending : Turning::light;
  // Never less than the pull alone, which rounding and noisy cells could make of a light torque.
  out.pull_n = std::max(patch.shear_n, least.ratio * patch.normal_n);
  out.pull_sigma_n = patch.normal_n * std::hypot(least.per_shear_n * patch.shear_sigma_n,
                                                 least.per_torque_nm * patch.torque_sigma_nm);
  if (!one_taxel_) {
    const double coarse = side_m_ / patch.radius_m;
    out.pull_sigma_n =
        std::hypot(out.pull_sigma_n, options_.coarse_sigma_share * std::min(1.0, coarse * coarse) *
                                         (out.pull_n - patch.shear_n));
  }
  follow(patch, out);
  return out;
}

}  // namespace slipd
