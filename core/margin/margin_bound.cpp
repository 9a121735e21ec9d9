#include "core/margin/margin_bound.hpp"

#include <algorithm>

#include "core/frame/significance.hpp"

namespace slipd {
namespace {

double greatest(const MeanSigma& value) noexcept {
  return value.mean + kOneSided95 * value.sigma;
}

}  // namespace

void MarginBound::apply(const SurfaceLoad& load, double internal_n, MarginDecision& decision,
                        Estimate& out) const noexcept {
  const double limit_n = decision.least_friction().value_or(known_.low) *
                         (load.normal_n.mean - kOneSided95 * load.normal_n.sigma);
  out.limit_low_n = std::max(0.0, limit_n);
  const double pull_n = (1 + kOneSided95 * load.common_sigma) *
                        std::max(greatest(load.pull_n), greatest(load.shear_n) + internal_n);
  // Under a skin the disc measures less of the shear than of the pressure.
  const bool hidden =
      !load.known && !decision.stands() && load.shear_n.mean > kClearSigmas * load.shear_n.sigma;
  decision.bound(limit_n > 0 && !hidden ? std::clamp(1 - pull_n / limit_n, 0.0, 1.0) : 0);
}

}  // namespace slipd
