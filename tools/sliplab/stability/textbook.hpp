// Hertz and Cattaneo–Mindlin as a textbook writes them, for any kind of number: the truth in many digits, and
// in few a picture of what the forms that slipd uses are for.
#pragma once

#include <cmath>

namespace sliplab {

// Plain values: E in Pa, R in m (infinity: flat, negative: concave), P in N, load = 1 - Gamma, s = r/a <= 1.
struct Case {
  double modulus_1, poisson_1, radius_1;
  double modulus_2, poisson_2, radius_2;
  double normal_n, friction, load, s;
};

template <class Real>
struct Traction {
  Real radius, peak, stick_radius, shear_n, pressure, shear, angle;
};

template <class Real>
Traction<Real> textbook(const Case& in) {
  using std::atan;
  using std::pow;
  using std::sqrt;
  const Real one = 1, three = 3, pi = 4 * atan(one);
  const auto curvature = [&](double radius) { return std::isinf(radius) ? Real(0) : one / Real(radius); };
  const auto compliance = [&](double modulus, double poisson) {
    return (one - Real(poisson) * Real(poisson)) / Real(modulus);
  };
  const Real normal = in.normal_n, mu = in.friction, gamma = one - Real(in.load), s = in.s;
  const Real modulus =
      one / (compliance(in.modulus_1, in.poisson_1) + compliance(in.modulus_2, in.poisson_2));
  const Real radius = one / (curvature(in.radius_1) + curvature(in.radius_2));
  Traction<Real> out;
  out.radius = pow(three * normal * radius / (4 * modulus), one / three);
  out.peak = three * normal / (2 * pi * out.radius * out.radius);
  const Real k = gamma > 0 ? Real(pow(gamma, one / three)) : Real(0);
  out.stick_radius = k * out.radius;
  out.shear_n = mu * normal * (one - gamma);
  out.pressure = out.peak * sqrt(one - s * s);
  out.shear = mu * out.pressure;
  if (s < k) out.shear -= mu * out.peak * k * sqrt(one - s * s / (k * k));
  out.angle = atan(out.shear / out.pressure);
  return out;
}

}  // namespace sliplab
