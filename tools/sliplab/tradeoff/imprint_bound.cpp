#include "tools/sliplab/tradeoff/imprint_bound.hpp"

#include <algorithm>
#include <cmath>

#include "core/numeric/scaled_inverse.hpp"

namespace sliplab {

using Model = slipd::ImprintModel;

double cramer_rao_sigma(Model& model, const KnownImprint& truth, double noise_share) noexcept {
  model.collect_nothing();
  model.set_noise({});
  const slipd::contact::Ellipse& ellipse = truth.ellipse;
  const double log_axes = std::log(ellipse.a_m / ellipse.b_m), twice = 2 * ellipse.angle_rad;
  Model::Full at = Model::Full::Zero();
  at[Model::center_x] = truth.x_m;
  at[Model::center_y] = truth.y_m;
  at[Model::size] = std::sqrt(ellipse.a_m * ellipse.b_m);
  at[Model::peak] = 1;
  at[Model::load] = truth.load;
  at[Model::margin] = truth.gamma;
  at[Model::direction] = truth.pull_rad;
  at[Model::along] = log_axes * std::cos(twice);
  at[Model::across] = log_axes * std::sin(twice);
  Model::Normal normal;
  model.evaluate(at, ellipse.round() ? int{Model::kRound} : int{Model::kMost}, normal);
  const auto pressures = model.residuals().first(model.count());
  const double greatest = *std::max_element(pressures.begin(), pressures.end());
  const slipd::ScaledInverse<Model::Square> inverse(normal.hessian);
  return noise_share * greatest * std::sqrt(inverse.variance(Model::margin));
}

}  // namespace sliplab
