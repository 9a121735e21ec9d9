#include "core/reading/torque/equivalent_pull.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slipd {

EquivalentPull::EquivalentPull(const TaxelLayout& layout, const EquivalentPullOptions& options)
    : options_(options),
      cells_(layout),
      unit_hertz_(contact::unit_hertz_surface()),
      side_m_(layout.side_m()),
      one_taxel_(layout.size() == 1),
      few_taxels_(!one_taxel_ && layout.size() <= options.few_taxels) {}

bool EquivalentPull::clear(const ContactPatch& patch) const noexcept {
  if (!(patch.radius_m > 0)) return false;
  const double torque_nm = std::fabs(patch.torque_nm), coarse = one_taxel_ ? 0 : side_m_ / patch.radius_m;
  const double least_share = options_.least_share + options_.coarse_share * coarse * coarse;
  const double sigmas = outweighs(patch) ? options_.outweighing_sigmas : options_.clear_sigmas;
  return torque_nm > sigmas * patch.torque_sigma_nm &&
         torque_nm > least_share * patch.shear_n * patch.radius_m;
}

// On few taxels: noise that is an unlikely torque would be most of the load, if it were one.
bool EquivalentPull::outweighs(const ContactPatch& patch) const noexcept {
  return few_taxels_ &&
         std::fabs(patch.torque_nm) > options_.outweighing_share * patch.shear_n * patch.radius_m;
}

// Loads are compared in newtons, both torques over one and the same lever: a grip that is tightened lowers
// the friction that the load needs, but the load has not fallen.
void EquivalentPull::follow(const ContactPatch& patch, EquivalentPullResult& out) noexcept {
  constexpr double kSigmas = 2;  // what noise may be of the load
  constexpr double kClear = 5;   // times that: there is a load whose path can be followed
  // T_max of Hertz over mu P a.
  constexpr double kTurnLever = 3 * std::numbers::pi / 16;
  if (!(patch.normal_n > 0)) return;
  const double lever_m = kTurnLever * patch.radius_m;
  const auto over_lever = [lever_m](double shear_n, double torque_nm) {
    return lever_m > 0 ? std::hypot(shear_n, torque_nm / lever_m) : shear_n;
  };
  const double load_n = over_lever(patch.shear_n, patch.torque_nm);
  const double noise_n =
      kSigmas * std::hypot(over_lever(patch.shear_sigma_n, patch.torque_sigma_nm), out.pull_sigma_n);
  const double most_n = over_lever(most_.shear_n, most_.torque_nm);
  if (load_n > kClear * noise_n && load_n >= options_.followed_share * most_n)
    follow_way(patch, load_n, noise_n);
  out.straight = way_.straight && load_n + noise_n >= options_.rising_share * most_n &&
                 !(way_.normal_n > 0 && patch.normal_n > (1 + options_.tightened_share) * way_.normal_n);
  out.risen = load_n + noise_n >= options_.risen_share * most_n;
  if (load_n - noise_n <= most_n) return;
  const double kept = 1 - noise_n / load_n;
  most_ = {kept * patch.shear_n, kept * patch.torque_nm};
}

// Sums up the part of each step of the path that is across the present load.
void EquivalentPull::follow_way(const ContactPatch& patch, double load_n, double noise_n) noexcept {
  const double lever_m = patch.radius_m, noise = noise_n / patch.normal_n;
  if (!(lever_m > 0)) return;
  if (load_n > options_.grown * way_.load_n) {
    way_.normal_n = patch.normal_n;
    way_.load_n = load_n;
  } else if (patch.normal_n < (1 + options_.tightened_share) * way_.normal_n) {
    way_.normal_n = std::min(way_.normal_n, patch.normal_n);
    way_.load_n = std::max(way_.load_n, load_n);
  }
  const LoadPoint now{patch.shear_x_n / patch.normal_n, patch.shear_y_n / patch.normal_n,
                      patch.torque_nm / (patch.normal_n * lever_m)};
  LoadPoint step{};
  double length = 0, squares = 0, along = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    step[i] = now[i] - way_.last[i];
    length += now[i] * now[i];
    squares += step[i] * step[i];
    along += step[i] * now[i];
  }
  if (!(squares > options_.step_share * options_.step_share * length)) return;
  way_.across += std::sqrt(std::max(0.0, squares - along * along / length - 2 * noise * noise));
  way_.last = now;
  way_.straight = way_.across < options_.straight_share * std::sqrt(length);
}

contact::LeastFriction EquivalentPull::least_friction(const ContactPatch& patch) noexcept {
  if (one_taxel_) {
    const double lever_m = patch.radius_m;
    contact::LeastFriction least =
        unit_hertz_.least_friction(patch.shear_x_n / patch.normal_n, patch.shear_y_n / patch.normal_n,
                                   patch.torque_nm / (patch.normal_n * lever_m));
    least.per_shear_n /= patch.normal_n;
    least.per_torque_nm /= patch.normal_n * lever_m;
    return least;
  }
  const contact::LimitSurface& surface = cells_.pool(patch);
  const double coarse = side_m_ / patch.radius_m;
  const double felt = cells_.are_taxels() ? 1 + options_.within_taxels * coarse * coarse : 1;
  return surface.least_friction(patch.shear_x_n, patch.shear_y_n, felt * patch.torque_nm);
}

EquivalentPullResult EquivalentPull::of(const ContactPatch& patch, double friction) noexcept {
  EquivalentPullResult out = weigh(patch);
  out.least_stuck = sticks_least(patch, out, friction);
  return out;
}

// After a pull what sticks bears P - Q/mu, and traces of earlier loads are wiped where that falls below all
// it was before (docs/methods.md §27.2). Loads far below the present one leave none that counts.
bool EquivalentPull::sticks_least(const ContactPatch& patch, const EquivalentPullResult& load,
                                  double friction) noexcept {
  const double stuck_n = patch.normal_n - load.pull_n / friction;
  const double least_n = least_stuck_.normal_n - least_stuck_.pull_n / friction;
  if (stuck_n <= least_n || load.pull_n > options_.grown * least_stuck_.pull_n) {
    least_stuck_ = {patch.normal_n, load.pull_n};
    return true;
  }
  const double noise_n = options_.stuck_sigmas * load.pull_sigma_n / friction;
  return stuck_n <= least_n + options_.stuck_share * patch.normal_n + noise_n;
}

EquivalentPullResult EquivalentPull::weigh(const ContactPatch& patch) noexcept {
  EquivalentPullResult out{.pull_n = patch.shear_n, .pull_sigma_n = patch.shear_sigma_n};
  const bool is_clear = clear(patch);
  if ((!is_clear && !outweighs(patch)) || !(patch.normal_n > 0) || !(patch.radius_m > 0)) {
    bent_ = false;
    follow(patch, out);
    return out;
  }
  const contact::LeastFriction least = least_friction(patch);
  if (!is_clear) {
    // Noise may be all of the torque, and the torque may be all that the object carries.
    bent_ = false;
    out.pull_sigma_n =
        std::hypot(out.pull_sigma_n, std::max(0.0, least.ratio * patch.normal_n - patch.shear_n));
    follow(patch, out);
    return out;
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
  out.along_per_n = least.per_shear_n;
  out.spin_per_nm = std::copysign(least.per_torque_nm, patch.torque_nm);
  follow(patch, out);
  return out;
}

}  // namespace slipd
