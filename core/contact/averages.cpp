#include "core/contact/averages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/numeric/norm.hpp"

namespace slipd::contact {
namespace {

// Nodes and weights of Gauss-Legendre on [-1/2, 1/2], weights summing to 1.
template <std::size_t N>
struct Gauss {
  std::array<double, N> node, weight;
};
constexpr Gauss<2> kGauss2{{-0.28867513459481287, 0.28867513459481287}, {0.5, 0.5}};
constexpr Gauss<4> kGauss4{
    {-0.43056815579702629, -0.16999052179242813, 0.16999052179242813, 0.43056815579702629},
    {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693}};

template <std::size_t N>
double quadrature(const Gauss<N>& rule, double radius, double u, double v, double side) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < N; ++i) {
    const double x = u + side * rule.node[i];
    const double rest = radius * radius - x * x;
    double line = 0;
    for (std::size_t j = 0; j < N; ++j) {
      const double y = v + side * rule.node[j];
      line += rule.weight[j] * std::sqrt(rest - y * y);
    }
    sum += rule.weight[i] * line;
  }
  return sum;
}

}  // namespace

// docs/theory.md §5.1, with w the height above (u, v):
//   uvw/3 + u(3x^2-u^2)/6 atan(v/w) + v(3x^2-v^2)/6 atan(u/w) - x^3/3 atan(uv/(xw)).
// Beyond the rim w = 0 and the angles are right ones, which leaves just the caps cut off: the same expression
// holds.
double hemisphere_over_rectangle(double x, double u, double v) noexcept {
  u = std::clamp(u, -x, x);
  v = std::clamp(v, -x, x);
  const double w = std::sqrt(std::max(0.0, x * x - u * u - v * v));
  return (2 * u * v * w + u * (3 * x * x - u * u) * std::atan2(v, w) +
          v * (3 * x * x - v * v) * std::atan2(u, w) - 2 * x * x * x * std::atan2(u * v, x * w)) /
         6;
}

double disc_average_exact(double radius, double u, double v, double side) noexcept {
  const double h = side / 2;
  return (hemisphere_over_rectangle(radius, u + h, v + h) - hemisphere_over_rectangle(radius, u - h, v + h) -
          hemisphere_over_rectangle(radius, u + h, v - h) + hemisphere_over_rectangle(radius, u - h, v - h)) /
         (side * side);
}

double disc_average(double radius, double u, double v, double side) noexcept {
  const double reach = side * (std::numbers::sqrt2 / 2);
  const double r = norm(u, v);
  if (r - reach >= radius) return 0;
  const double inside = radius - r;
  if (inside > 12 * side) return quadrature(kGauss2, radius, u, v, side);
  if (inside > 2 * side) return quadrature(kGauss4, radius, u, v, side);
  return disc_average_exact(radius, u, v, side);
}

void taxel_averages(const TaxelLayout& layout, double center_x_m, double center_y_m,
                    const LoadHistory& contact, std::span<float> normal_pa,
                    std::span<float> shear_pa) noexcept {
  const double scale = contact.pair().disc_scale_pa_per_m();
  const double side = layout.side_m();
  const double a = contact.contact_radius_m();
  const double reach = a + side * (std::numbers::sqrt2 / 2);
  const auto terms = contact.shear_terms();
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const double u = layout.x_m()[i] - center_x_m, v = layout.y_m()[i] - center_y_m;
    if (u * u + v * v >= reach * reach) {
      normal_pa[i] = shear_pa[i] = 0;
      continue;
    }
    const double pressure = disc_average(a, u, v, side);
    double shear = 0;
    for (const auto& term : terms) {  // the largest disc is the contact itself: not integrated twice
      shear += term.coefficient * (term.radius_m == a ? pressure : disc_average(term.radius_m, u, v, side));
    }
    normal_pa[i] = static_cast<float>(scale * pressure);
    shear_pa[i] = static_cast<float>(scale * shear);
  }
}

}  // namespace slipd::contact
