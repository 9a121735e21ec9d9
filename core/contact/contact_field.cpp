#include "core/contact/contact_field.hpp"

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>

namespace slipd::contact {
namespace {

// Domes that a profile other than a sphere's is summed of.
constexpr unsigned kDomes = 20;

}  // namespace

ContactField::ContactField(const TaxelLayout& layout, const ContactGeometry& geometry)
    : geometry_(geometry),
      sheet_(layout.size(), layout.side_m(), geometry.depth_m, geometry.bonded_poisson),
      x_m_(layout.x_m().begin(), layout.x_m().end()),
      y_m_(layout.y_m().begin(), layout.y_m().end()) {
  for (auto* list : {&u_, &v_, &normal_, &shear_x_, &shear_y_}) list->resize(layout.size());
}

void ContactField::add_dome(double radius_m, double height_pa, const Force& force) noexcept {
  const double long_over_mean = std::sqrt(geometry_.stretch);
  sheet_.evaluate_values({radius_m * long_over_mean, radius_m / long_over_mean, geometry_.angle_rad}, u_, v_);
  using Sheet = SubsurfaceSheet;
  const auto of = [&](Sheet::Component component) { return sheet_.row(Sheet::value, component); };
  const auto nn = of(Sheet::nn), nx = of(Sheet::nx), ny = of(Sheet::ny), xx = of(Sheet::xx),
             xy = of(Sheet::xy), yy = of(Sheet::yy), xn = of(Sheet::xn), yn = of(Sheet::yn);
  const double p = height_pa * force.normal, x = height_pa * force.shear_x, y = height_pa * force.shear_y;
  for (std::size_t i = 0; i < nn.size(); ++i) {
    normal_[i] += nn[i] * p + nx[i] * x + ny[i] * y;
    shear_x_[i] += xn[i] * p + xx[i] * x + xy[i] * y;
    shear_y_[i] += yn[i] * p + xy[i] * x + yy[i] * y;
  }
}

// The pressure under a gap of r^n is c (a^(n-2) D_a - (n-2) integral of x^(n-3) D_x dx over 0 … a) with
// D_x = sqrt(x^2 - r^2) and c = F (n+1)/(2 pi a^(n+1)) (docs/theory.md §4.6).
void ContactField::add_term(double force_n, double round_radius_m, const Force& force) noexcept {
  const double n = geometry_.power;
  if (!(force_n > 0)) return;
  // As large as Hertz's at 1 N, and from there on with F^(1/(n+1)).
  const double a = round_radius_m * std::pow(force_n, 1 / (n + 1) - 1.0 / 3);
  const double height_pa = force_n * (n + 1) / (2 * std::numbers::pi * a * a);
  add_dome(a, height_pa, force);
  if (n == 2) return;
  using Rule = boost::math::quadrature::gauss<double, kDomes>;
  const auto& node = Rule::abscissa();
  const auto& share = Rule::weights();
  for (std::size_t i = 0; i < node.size(); ++i) {
    for (const double sign : {-1.0, 1.0}) {
      const double s = 0.5 * (1 + sign * node[i]);
      add_dome(s * a, -0.5 * share[i] * height_pa * (n - 2) * std::pow(s, n - 2), force);
    }
  }
}

void ContactField::sense(const LoadHistory& contact, double x_m, double y_m, double pull_rad,
                         std::span<float> normal_pa, std::span<float> shear_x_pa,
                         std::span<float> shear_y_pa) noexcept {
  for (auto* list : {&normal_, &shear_x_, &shear_y_}) std::fill(list->begin(), list->end(), 0.0);
  for (std::size_t i = 0; i < x_m_.size(); ++i) {
    u_[i] = x_m_[i] - x_m;
    v_[i] = y_m_[i] - y_m;
  }
  const double c = std::cos(pull_rad), s = std::sin(pull_rad), a = contact.contact_radius_m();
  Force outer{.normal = 1};
  for (const DiscTerm& term : contact.shear_terms()) {
    const Force pull{0, term.coefficient * c, term.coefficient * s};
    if (term.radius_m == a) {  // the contact itself: not integrated twice
      outer = {1, outer.shear_x + pull.shear_x, outer.shear_y + pull.shear_y};
    } else {
      add_term(contact.pair().disc_force_n(term.radius_m), term.radius_m, pull);
    }
  }
  add_term(contact.normal_n(), a, outer);
  const auto written = [](const std::vector<double>& from, std::span<float> to) {
    std::transform(from.begin(), from.end(), to.begin(), [](double x) { return static_cast<float>(x); });
  };
  written(normal_, normal_pa);
  written(shear_x_, shear_x_pa);
  written(shear_y_, shear_y_pa);
}

}  // namespace slipd::contact
