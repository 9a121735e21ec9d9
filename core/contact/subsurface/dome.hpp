// The dome sqrt(x^2 - r^2) averaged over many taxels at once, with its derivatives (docs/theory.md §5.1):
// what fitting a contact to taxels evaluates thousands of times a second. The same closed form as
// disc_average_exact, written so that the compiler turns it into vector instructions: no branch, always
// inlined (a call in a loop keeps it scalar), and an arc tangent of its own that is good to 1e-14.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <type_traits>

namespace slipd::contact {

// atan(t) for t = y / x with x >= 0, y of any sign; 0 where both vanish. Absolute error below 2e-15, of
// single precision below 2e-7.
template <typename Real>
[[gnu::always_inline]] inline Real angle_from_height(Real y, Real x) noexcept {
  constexpr auto kPi = std::numbers::pi_v<Real>, kRoot2 = std::numbers::sqrt2_v<Real>;
  const Real ay = std::fabs(y);
  const Real small = std::min(ay, x), large = std::max(std::max(ay, x), std::numeric_limits<Real>::min());
  // Two reductions, small/large in [0, 1] and then to |z| <= sqrt(2) - 1, taken by one division.
  const bool upper = small > (kRoot2 - 1) * large;
  const Real part = upper ? Real(1) : Real(0);
  const Real z = (small - part * large) / (large + part * small);
  const Real w = z * z;
  Real series;
  if constexpr (std::is_same_v<Real, float>) {  // minimax of atan(z)/z, within 2e-8
    series = 0.07993644F;
    series = series * w - 0.13854458F;
    series = series * w + 0.19974724F;
    series = series * w - 0.33332808F;
    series = series * w + 0.99999998F;
  } else {
    series = -0.02531472973194233;
    series = series * w + 0.050246342455960435;
    series = series * w - 0.06505944155503311;
    series = series * w + 0.07673529098467827;
    series = series * w - 0.09089529357362555;
    series = series * w + 0.11111048820585145;
    series = series * w - 0.14285712660659053;
    series = series * w + 0.1999999997837687;
    series = series * w - 0.33333333333221343;
    series = series * w + 0.999999999999999;
  }
  Real angle = z * series + part * (kPi / 4);
  angle = ay > x ? kPi / 2 - angle : angle;
  return y < 0 ? -angle : angle;
}

// One taxel's average and derivatives, in units of lengths as given.
struct DomeAverage {
  double value = 0;  // average of sqrt(x^2 - r^2) where real, else 0
  double d_x = 0;    // by the dome's radius x
  double d_u = 0;    // by the taxel's place relative to the dome's centre
  double d_v = 0;
};

// The same of many taxels, a list each.
struct DomeAverages {
  std::span<double> value, d_x, d_u, d_v;
};

// The integral over the rectangle from the origin to (u, v) and its derivatives; w is the height above the
// corner.
template <typename Real>
struct DomeCorner {
  Real value, d_x, d_u, d_v;
};

template <typename Real>
[[gnu::always_inline]] inline DomeCorner<Real> dome_corner(Real x, Real u, Real v) noexcept {
  u = std::clamp(u, -x, x);
  v = std::clamp(v, -x, x);
  const Real w = std::sqrt(std::max(Real(0), x * x - u * u - v * v));
  const Real over_u = angle_from_height(v, w), over_v = angle_from_height(u, w);
  const Real over_both = angle_from_height(u * v, x * w);
  const Real xx = x * x, uu = u * u, vv = v * v;
  return {Real(1.0 / 6) * (2 * u * v * w + u * (3 * xx - uu) * over_u + v * (3 * xx - vv) * over_v -
                           2 * xx * x * over_both),
          x * (u * over_u + v * over_v - x * over_both), Real(0.5) * (v * w + (xx - uu) * over_u),
          Real(0.5) * (u * w + (xx - vv) * over_v)};
}

// The average over the square of `side` about (u, v). x >= 0.
[[gnu::always_inline]] inline DomeAverage dome_average(double x, double u, double v, double side) noexcept {
  const double h = side / 2, per_area = 1 / (side * side);
  const auto a = dome_corner(x, u + h, v + h), b = dome_corner(x, u - h, v + h);
  const auto c = dome_corner(x, u + h, v - h), d = dome_corner(x, u - h, v - h);
  return {(a.value - b.value - c.value + d.value) * per_area, (a.d_x - b.d_x - c.d_x + d.d_x) * per_area,
          (a.d_u - b.d_u - c.d_u + d.d_u) * per_area, (a.d_v - b.d_v - c.d_v + d.d_v) * per_area};
}

}  // namespace slipd::contact
