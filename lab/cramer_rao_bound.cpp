#include "lab/cramer_rao_bound.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/contact/subsurface/dome.hpp"
#include "core/estimate/estimate.hpp"
#include "core/numeric/scaled_inverse.hpp"

namespace lab {

using namespace slipd;

namespace {

constexpr double kPriorPrecision = 12;  // 1 / variance of the uniform distribution on 0 … 1
enum Unknown { center_x, center_y, radius, height, load, margin };
constexpr int kUnknowns = margin + 1;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;

double normal_below(double x) {
  return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

}  // namespace

// In units of a and p0: p = A(1), q = mu (A(1) - A(k)); A the average of sqrt(x^2 - r^2) over a taxel, exact.
double cramer_rao_sigma(const TaxelLayout& layout, const contact::BodyPair& pair, const ContactDraw& draw,
                        double gamma, NoiseKind kind, double noise) {
  const double a = pair.contact_radius_m(draw.normal_n), side = layout.side_m() / a;
  const double k = std::cbrt(gamma), mu = draw.friction;
  Square pressure = Square::Zero(), shear = Square::Zero();
  double most_p = 0, most_q = 0;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const double u = (layout.x_m()[i] - draw.x_m) / a, v = (layout.y_m()[i] - draw.y_m) / a;
    const double reach = 1 + side * (std::numbers::sqrt2 / 2);
    if (u * u + v * v >= reach * reach) continue;
    const auto outer = contact::dome_average(1, u, v, side), inner = contact::dome_average(k, u, v, side);
    const double q = mu * (outer.value - inner.value);
    most_p = std::max(most_p, outer.value);
    most_q = std::max(most_q, q);
    Vector by;
    by << -outer.d_u, -outer.d_v, outer.d_x, outer.value, 0, 0;
    pressure += by * by.transpose();
    // T = mu (1 - Gamma) instead of mu: the information on Gamma is the same, and stays finite at its ends.
    const double rest = 1 - gamma, dk = 1 / (3 * k * k);
    by << -mu * (outer.d_u - inner.d_u), -mu * (outer.d_v - inner.d_v), mu * (outer.d_x - k * inner.d_x), q,
        q / (mu * rest), q / rest - mu * dk * inner.d_x;
    shear += by * by.transpose();
  }
  const double of_uniform = noise / std::numbers::sqrt3;
  const double sigma_p = of_uniform * most_p,
               sigma_q = kind == NoiseKind::sensor ? sigma_p : of_uniform * most_q;
  const Square information = pressure / (sigma_p * sigma_p) + shear / (sigma_q * sigma_q);
  return std::sqrt(ScaledInverse<Square>(information).variance(margin));
}

CramerRaoBound mean_cramer_rao_bound(const TaxelLayout& layout, const Scene& scene, NoiseKind kind,
                                     double noise, std::size_t contacts, std::uint64_t seed) {
  CramerRaoBound sum{0, 0};
  for (std::size_t i = 0; i < contacts; ++i) {
    const ContactDraw draw = draw_contact(scene, seed, i);
    const double gamma = RandomStream(seed ^ 0x6c696d6974ULL).uniform(i, 0.001, 0.999);
    const auto pair =
        contact::make_body_pair(contact::body_of(scene.skin), {draw.radius_m, draw.modulus_pa, draw.poisson});
    const double alone = cramer_rao_sigma(layout, pair, draw, gamma, kind, noise);
    const double sigma = 1 / std::sqrt(1 / (alone * alone) + kPriorPrecision);
    sum.mean_error += std::sqrt(2 / std::numbers::pi) * sigma;
    const int own = slip_class(gamma);
    const double low = own == 1 ? -std::numeric_limits<double>::infinity() : 0.2 * (own - 1);
    const double high = own == 5 ? std::numeric_limits<double>::infinity() : 0.2 * own;
    sum.class_correct += normal_below((high - gamma) / sigma) - normal_below((low - gamma) / sigma);
  }
  const auto n = static_cast<double>(contacts);
  return {sum.mean_error / n, sum.class_correct / n};
}

}  // namespace lab
