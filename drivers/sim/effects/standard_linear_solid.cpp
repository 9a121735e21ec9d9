#include "drivers/sim/effects/standard_linear_solid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slipd::sim {

// With e = excess: de/dt = dF/dt - e/tau, solved for a constant dF/dt.
double StandardLinearSolid::update(double at_rest_n, double dt_s) noexcept {
  const double change_n = at_rest_n - std::exchange(at_rest_n_, at_rest_n);
  const double times = dt_s / settings_.relaxation_s;
  const double kept = std::exp(-times);
  excess_n_ = kept * excess_n_ + change_n * (times > 0 ? (1 - kept) / times : 1);
  return std::max(0.0, at_rest_n + (settings_.stiffening - 1) * excess_n_);
}

}  // namespace slipd::sim
