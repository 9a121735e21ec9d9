#include "core/contact/cattaneo_mindlin.hpp"

#include <cmath>
#include <sstream>

namespace slipd::contact {

CattaneoMindlin::CattaneoMindlin(const BodyPair& pair, double normal_n, double friction,
                                 double one_minus_gamma)
    : normal_(normal_n), friction_(friction), load_(one_minus_gamma) {
  check_normal_force(normal_n);
  check_friction(friction);
  if (!(one_minus_gamma >= 0 && one_minus_gamma <= 1)) {
    std::ostringstream text;
    text.precision(17);
    text << "1 - Gamma = " << one_minus_gamma << ": must be in [0, 1]";
    throw ContactError(text.str());
  }
  a_ = pair.contact_radius_m(normal_n);
  p0_ = pair.peak_pressure_pa(normal_n);
  k_ = std::cbrt(1 - load_);
  // log1p(-1) is -inf and expm1 of it -1: gross slip needs no case of its own.
  one_minus_k2_ = -std::expm1(2.0 / 3.0 * std::log1p(-load_));
}

// docs/theory.md §3.2. In the stick zone q/(mu p) = 1 - sqrt(u), u = (k^2 - s^2)/(1 - s^2). The difference is
// taken as (1 - u)/(1 + sqrt(u)) with 1 - u = (1 - k^2)/(1 - s^2); and k - s, where u is small, as (k^3 -
// s^3)/(k^2 + ks + s^2), because k^3 = Gamma is known to all its digits and its root is not: from whichever
// side of 1/2 the subtraction from 1 is exact.
double CattaneoMindlin::mobilised_friction(double s) const noexcept {
  if (load_ == 0) return 0;
  if (s >= k_) return 1;
  const double one_minus_s2 = (1 - s) * (1 + s);
  const double cubes = load_ <= 0.5 ? (1 - s) * (1 + s + s * s) - load_ : (1 - load_) - s * s * s;
  const double u = cubes / (k_ * k_ + k_ * s + s * s) * (k_ + s) / one_minus_s2;
  if (!(u > 0)) return 1;
  return one_minus_k2_ / one_minus_s2 / (1 + std::sqrt(u));
}

Traction CattaneoMindlin::at(double s) const noexcept {
  if (normal_ == 0 || !(s <= 1)) return {};
  const double utilisation = mobilised_friction(s);
  const double pressure = p0_ * std::sqrt((1 - s) * (1 + s));
  // In this order no product of small factors falls below the normal doubles before the result does.
  return {pressure, pressure * friction_ * utilisation, std::atan(friction_ * utilisation)};
}

}  // namespace slipd::contact
