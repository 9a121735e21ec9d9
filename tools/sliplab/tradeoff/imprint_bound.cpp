#include "tools/sliplab/tradeoff/imprint_bound.hpp"

#include <algorithm>
#include <cmath>

#include "core/numeric/scaled_inverse.hpp"

namespace sliplab {

using slipd::ImprintModel;

double cramer_rao_sigma(ImprintModel& model, const KnownImprint& truth, double noise_share) noexcept {
  model.collect_nothing();
  model.set_noise({});
  const slipd::contact::Ellipse& ellipse = truth.ellipse;
  const double log_axes = std::log(ellipse.a_m / ellipse.b_m), twice = 2 * ellipse.angle_rad;
  ImprintModel::Full at = ImprintModel::Full::Zero();
  at[ImprintModel::center_x] = truth.x_m;
  at[ImprintModel::center_y] = truth.y_m;
  at[ImprintModel::size] = std::sqrt(ellipse.a_m * ellipse.b_m);
  at[ImprintModel::peak] = 1;
  at[ImprintModel::load] = truth.load;
  at[ImprintModel::margin] = truth.gamma;
  at[ImprintModel::direction] = truth.pull_rad;
  at[ImprintModel::along] = log_axes * std::cos(twice);
  at[ImprintModel::across] = log_axes * std::sin(twice);
  ImprintModel::Normal normal;
  model.evaluate(at, ellipse.round() ? int{ImprintModel::kRound} : int{ImprintModel::kMost}, normal);
  normal.hessian(ImprintModel::depth, ImprintModel::depth) = ImprintModel::kHeldDepth;
  const auto pressures = model.residuals().first(model.count());
  const double greatest = *std::max_element(pressures.begin(), pressures.end());
  const slipd::ScaledInverse<ImprintModel::Square> inverse(normal.hessian);
  return noise_share * greatest * std::sqrt(inverse.variance(ImprintModel::margin));
}

}  // namespace sliplab
