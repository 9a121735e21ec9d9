#include "core/friction/unobserved_load_change.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

constexpr double kNoise = 4;  // deviations of a difference of forces that noise alone hardly makes

}  // namespace

void UnobservedLoadChange::update(const ContactPatch& patch, double friction) noexcept {
  moved_ *= std::exp(-1 / kFadeFrames);
  if (any_ && patch.normal_n > 0 && friction > 0) {
    const double shear_n = std::hypot(patch.shear_x_n - shear_x_n_, patch.shear_y_n - shear_y_n_);
    const double moved_n = std::hypot(patch.normal_n - normal_n_, shear_n / friction);
    const double noise_n = kNoise * std::hypot(patch.normal_sigma_n, patch.shear_sigma_n / friction);
    const double moved = std::min(1.0, (moved_n - noise_n) / patch.normal_n);
    if (moved > kSeen) moved_ = std::max(moved_, moved);
  }
  any_ = true;
  normal_n_ = patch.normal_n;
  shear_x_n_ = patch.shear_x_n;
  shear_y_n_ = patch.shear_y_n;
}

}  // namespace slipd
