#include "core/load/unobserved_load_change.hpp"

#include <algorithm>
#include <cmath>

#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

constexpr double kNoise = 4;  // deviations of a difference of forces that noise alone hardly makes

}  // namespace

void UnobservedLoadChange::update(const ContactPatch& patch, const LoadStep& step, double friction) noexcept {
  moved_ *= std::exp(-1 / kFadeFrames);
  if (!step.previous || !(patch.normal_n > 0) || !(friction > 0)) return;
  const double moved_n =
      norm(step.now.measured.normal_n - step.previous->measured.normal_n, step.shear_moved_n() / friction);
  const double noise_n = kNoise * norm(patch.normal_sigma_n, patch.shear_sigma_n / friction);
  const double moved = std::min(1.0, (moved_n - noise_n) / patch.normal_n);
  if (moved > kSeen) moved_ = std::max(moved_, moved);
}

}  // namespace slipd
