// The textbook formulas of Hertz and Cattaneo–Mindlin for any number type: the reference in many digits, and
// in few digits the rounding errors that slipd's forms avoid.
#pragma once

#include <cmath>

namespace lab {

// The parameters of one contact and one point of it.
struct Case {
  double modulus_1;  // Young's modulus of the skin, Pa
  double poisson_1;  // Poisson's ratio of the skin
  double radius_1;   // radius of the skin, m; infinity: flat, negative: concave
  double modulus_2;  // of the object, Pa
  double poisson_2;  // of the object
  double radius_2;   // of the object, m; infinity: flat, negative: concave
  double normal_n;   // normal force P, N
  double friction;   // mu
  double load;       // 1 - Gamma = Q / (mu P)
  double s;          // r / a, 0 … 1
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

}  // namespace lab
