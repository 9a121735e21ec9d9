// The contact model by its textbook formulas in 400 digits, where cancellation and overflow do not matter:
// the reference for the formulas in double.
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>

#include "core/contact/hertz.hpp"

namespace slipd::contact::precise {

using Real =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<400>, boost::multiprecision::et_off>;

struct Reference {
  Real modulus, radius, a, p0, c, shear, pressure, traction, angle;
};

inline Real root3(const Real& x) {
  return x == 0 ? Real(0) : boost::multiprecision::exp(boost::multiprecision::log(x) / 3);
}

inline Reference reference(const Body& one, const Body& two, double normal, double mu, double load,
                           double s) {
  using boost::multiprecision::atan;
  using boost::multiprecision::sqrt;
  const Real pi = 4 * atan(Real(1));
  const auto curvature = [](double r) { return std::isinf(r) ? Real(0) : Real(1) / Real(r); };
  const auto compliance = [](const Body& b) { return (1 - Real(b.poisson) * b.poisson) / b.modulus_pa; };
  Reference out;
  out.modulus = 1 / (compliance(one) + compliance(two));
  out.radius = 1 / (curvature(one.radius_m) + curvature(two.radius_m));
  out.a = root3(3 * Real(normal) * out.radius / (4 * out.modulus));
  out.p0 = 3 * Real(normal) / (2 * pi * out.a * out.a);
  const Real k = root3(1 - Real(load));
  out.c = out.a * k;
  out.shear = Real(load) * mu * normal;
  const Real dome = sqrt(1 - Real(s) * s);
  out.pressure = out.p0 * dome;
  out.traction = Real(mu) * out.p0 * dome;
  if (load > 0 && s < k) out.traction -= Real(mu) * out.p0 * sqrt(k * k - Real(s) * s);
  if (load == 0) out.traction = 0;
  out.angle = load == 0 ? Real(0) : s == 1 ? atan(Real(mu)) : atan(out.traction / out.pressure);
  return out;
}

// |got - want| relative to want. Where want is below the normal doubles: relative to the smallest normal
// double.
inline double error(double got, const Real& want) {
  const Real least = std::numeric_limits<double>::min();
  const Real size = abs(want) > least ? Real(abs(want)) : least;
  return static_cast<double>(abs(Real(got) - want) / size);
}

}  // namespace slipd::contact::precise
