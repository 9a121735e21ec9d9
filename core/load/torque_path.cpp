#include "core/load/torque_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/contact/partial_slip.hpp"
#include "core/frame/significance.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

constexpr double kClear = 5;  // times what noise may be of it: there is a load whose path can be followed
// T_max of Hertz over mu P a.
constexpr double kTurnLever = 3 * std::numbers::pi / 16;

}  // namespace

void TorquePath::lose_sight() noexcept {
  forget();
  path_.across = std::numeric_limits<double>::infinity();
  path_.straight = false;
}

TorquePathState TorquePath::follow(const ContactPatch& patch, const EquivalentPullResult& pull,
                                   double friction) noexcept {
  TorquePathState out;
  if (patch.normal_n > 0) follow_load(patch, pull, out);
  out.least_stuck = sticks_least(patch, pull, friction);
  return out;
}

// Loads are compared in newtons, both torques over one and the same lever: a grip that is tightened lowers
// the friction that the load needs, but the load has not fallen.
void TorquePath::follow_load(const ContactPatch& patch, const EquivalentPullResult& pull,
                             TorquePathState& out) noexcept {
  const double lever_m = kTurnLever * patch.radius_m;
  const auto over_lever = [lever_m](double shear_n, double torque_nm) {
    return lever_m > 0 ? norm(shear_n, torque_nm / lever_m) : shear_n;
  };
  const double load_n = over_lever(patch.shear_n, patch.torque_nm);
  const double noise_n =
      kAlikeSigmas * norm(over_lever(patch.shear_sigma_n, patch.torque_sigma_nm), pull.pull_sigma_n);
  const double most_n = over_lever(path_.most.shear_n, path_.most.torque_nm);
  if (load_n > kClear * noise_n && load_n >= most_n / 2) follow_direction(patch, load_n, noise_n);
  const bool tightened = path_.grip_n > 0 && patch.normal_n > (1 + options_.steady_share) * path_.grip_n;
  out.straight = path_.straight && load_n + noise_n >= (1 - options_.steady_share) * most_n && !tightened;
  out.risen = load_n + noise_n >= options_.risen_share * most_n;
  if (load_n - noise_n <= most_n) return;
  const double kept = 1 - noise_n / load_n;
  path_.most = {kept * patch.shear_n, kept * patch.torque_nm};
}

// Sums up the part of each step of the path that is across the present load.
void TorquePath::follow_direction(const ContactPatch& patch, double load_n, double noise_n) noexcept {
  const double lever_m = patch.radius_m, noise = noise_n / patch.normal_n;
  if (!(lever_m > 0)) return;
  if (load_n > kGrown * path_.at_grip_n) {
    path_.grip_n = patch.normal_n;
    path_.at_grip_n = load_n;
  } else if (patch.normal_n < (1 + options_.steady_share) * path_.grip_n) {
    path_.grip_n = std::min(path_.grip_n, patch.normal_n);
    path_.at_grip_n = std::max(path_.at_grip_n, load_n);
  }
  const Point now{patch.shear_x_n / patch.normal_n, patch.shear_y_n / patch.normal_n,
                  patch.torque_nm / (patch.normal_n * lever_m)};
  double length = 0, squares = 0, along = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const double step = now[i] - path_.last[i];
    length += now[i] * now[i];
    squares += step * step;
    along += step * now[i];
  }
  if (!(squares > contact::kIncrement * contact::kIncrement * length)) return;
  path_.across += std::sqrt(std::max(0.0, squares - along * along / length - 2 * noise * noise));
  path_.last = now;
  path_.straight = path_.across < contact::kIncrement * std::sqrt(length);
}

// After a pull what sticks bears P - Q/mu, and traces of earlier loads are wiped where that falls below all
// it was before. Loads far below the present one leave none that counts.
bool TorquePath::sticks_least(const ContactPatch& patch, const EquivalentPullResult& pull,
                              double friction) noexcept {
  StuckState& least = path_.least_stuck;
  const double stuck_n = patch.normal_n - pull.pull_n / friction;
  const double least_n = least.normal_n - least.pull_n / friction;
  if (stuck_n <= least_n || pull.pull_n > kGrown * least.pull_n) {
    least = {patch.normal_n, pull.pull_n};
    return true;
  }
  const double noise_n = kClearSigmas * pull.pull_sigma_n / friction;
  return stuck_n <= least_n + kChanged * patch.normal_n + noise_n;
}

}  // namespace slipd
