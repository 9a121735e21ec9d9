#include "lab/tradeoff/shape_bound.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/contact/history.hpp"
#include "core/numeric/scaled_inverse.hpp"

namespace lab {

using slipd::ContactShape;

double cramer_rao_sigma(ContactShape& model, const KnownContact& truth, double noise_share) noexcept {
  model.collect_nothing();
  model.set_noise({});
  const slipd::contact::Ellipse& ellipse = truth.ellipse;
  const double log_axes = std::log(ellipse.a_m / ellipse.b_m), twice = 2 * ellipse.angle_rad;
  ContactShape::Full at = ContactShape::Full::Zero();
  at[ContactShape::center_x] = truth.x_m;
  at[ContactShape::center_y] = truth.y_m;
  at[ContactShape::size] = std::sqrt(ellipse.a_m * ellipse.b_m);
  at[ContactShape::peak] = 1;
  at[ContactShape::load] = truth.load;
  at[ContactShape::margin] = truth.gamma;
  at[ContactShape::direction] = truth.pull_rad;
  at[ContactShape::along] = log_axes * std::cos(twice);
  at[ContactShape::across] = log_axes * std::sin(twice);
  ContactShape::Normal normal;
  model.evaluate(at, ellipse.round() ? int{ContactShape::kRound} : int{ContactShape::kMost}, normal);
  normal.hessian(ContactShape::depth, ContactShape::depth) = ContactShape::kHeldDepth;
  const auto pressures = model.residuals().first(model.count());
  const double greatest = *std::max_element(pressures.begin(), pressures.end());
  const slipd::ScaledInverse<ContactShape::Square> inverse(normal.hessian);
  return noise_share * greatest * std::sqrt(inverse.variance(ContactShape::margin));
}

double cramer_rao_sigma_by_closing(slipd::contact::ContactField& sheet, std::size_t taxels,
                                   const slipd::contact::BodyPair& pair, double normal_n,
                                   const KnownContact& truth, double noise_share) {
  const auto n = static_cast<Eigen::Index>(taxels);
  std::vector<float> p(taxels), x(taxels), y(taxels);
  const auto sensed = [&](const KnownContact& of, double force_n) {
    const double friction = of.load / (1 - of.gamma);
    slipd::contact::LoadHistory contact(pair);
    contact.move_to(force_n, 0, friction);
    contact.move_to(force_n, of.load * force_n, friction);
    sheet.sense(contact, of.x_m, of.y_m, of.pull_rad, p, x, y);
    Eigen::VectorXd all(3 * n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto taxel = static_cast<std::size_t>(i);
      all[i] = x[taxel];
      all[n + i] = y[taxel];
      all[2 * n + i] = p[taxel];
    }
    return all;
  };
  // Central differences; averages are single precision.
  Eigen::Matrix<double, Eigen::Dynamic, 6> slopes(3 * n, 6);
  const auto by = [&](Eigen::Index column, double KnownContact::*unknown, double step) {
    KnownContact above = truth, below = truth;
    above.*unknown += step;
    below.*unknown -= step;
    slopes.col(column) = (sensed(above, normal_n) - sensed(below, normal_n)) / (2 * step);
  };
  by(0, &KnownContact::gamma, std::min({0.01, 0.2 * truth.gamma, 0.2 * (1 - truth.gamma)}));
  by(1, &KnownContact::load, 0.01 * truth.load);
  by(2, &KnownContact::pull_rad, 0.01);
  constexpr double kForceStep = 0.01, kShift = 1e-4;  // of the force; m
  slopes.col(3) = (sensed(truth, (1 + kForceStep) * normal_n) - sensed(truth, (1 - kForceStep) * normal_n)) /
                  (2 * kForceStep);
  by(4, &KnownContact::x_m, kShift);
  by(5, &KnownContact::y_m, kShift);
  slopes.topRightCorner(2 * n, 2).setZero();  // of the pressure alone
  sensed(truth, normal_n);
  const double greatest = *std::max_element(p.begin(), p.end());
  const slipd::ScaledInverse<Eigen::Matrix<double, 6, 6>> inverse(slopes.transpose() * slopes);
  return noise_share * greatest * std::sqrt(inverse.variance(0));
}

}  // namespace lab
