#include "core/estimate/hertz_deviation.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

constexpr double kClear = 3;  // deviations: noise alone is that once in hundreds of frames
// What squares on a round rim make of each, over (side/a)^3.
constexpr double kRimTilt = 0.75, kRimLonger = 0.15, kRimKurtosis = 0.6;
// What a taxel makes of the spread that feels less than its whole square, over (side/a)^2.
constexpr double kPointKurtosis = 0.2;

// `sliplab stability --parts adversary` on 16 x 16 to 100 x 100 taxels: what Gamma is off by, over each.
constexpr double kTiltSigma = 0.22;         // the less the more of it there is
constexpr double kEllipticitySigma = 0.35;  // over its square
constexpr double kKurtosisSigma = 2;
constexpr double kMostEllipticity = 0.5, kMostKurtosis = 0.06;

double square(double x) noexcept {
  return x * x;
}

// <x (x^2 + y^2)>, about the centroid, is 0 of a round contact and -8/175 t a^3 of a skewed one. Noise moves
// the centroid, too, and by that 4/5 of its own lever.
double tilt_of(const MomentSums& sums, const ContactPatch& patch, double rim) noexcept {
  constexpr double kPerTilt = 8.0 / 175, kCentroid = 0.8;
  const double unit = 1 / (kPerTilt * patch.radius_m * sums.p);
  const double levers = sums.s3 - 2 * kCentroid * sums.s2 + square(kCentroid) * sums.s;
  const double noise = patch.noise_normal_pa / (kPerTilt * sums.p);
  const double variance = 0.5 * square(noise) * std::max(0.0, levers) + square(kRimTilt * rim);
  const double squares = square(unit * sums.psx) + square(unit * sums.psy);
  return squares > square(kClear) * variance ? std::sqrt(squares - 2 * variance) : 0;
}

}  // namespace

bool HertzDeviation::hertzian() const noexcept {
  return excess_kurtosis < kMostKurtosis && ellipticity < kMostEllipticity;
}

double HertzDeviation::sigma() const noexcept {
  return std::hypot(kTiltSigma * tilt / (1 + 2 * tilt), kEllipticitySigma * square(ellipticity),
                    kKurtosisSigma * excess_kurtosis);
}

// <r^4>/<r^2>^2 of the pressure is 10/7 of a round contact, and half the square of its elongation more, as a
// share, of an elliptic one. What is left over a skin that spreads stress adds.
HertzDeviation hertz_deviation(const MomentSums& sums, const ContactPatch& patch, double side_m) noexcept {
  constexpr double kRound = 10.0 / 7;
  HertzDeviation out;
  const double side2 = square(side_m / patch.radius_m), rim = side2 * side_m / patch.radius_m;
  out.tilt = tilt_of(sums, patch, rim);
  const double s = sums.ps / sums.p - side2 / 6,
               s2 = sums.pss / sums.p - 2.0 / 3 * side2 * s - kSquareFourth * square(side2);
  if (!(s > 0)) return out;
  const double noise = patch.noise_normal_pa / sums.p;
  const double longer = std::hypot(sums.px2y2, 2 * sums.pxy) / (sums.p * s);
  const double longer_open = std::hypot(noise * std::sqrt(0.5 * sums.s2) / s, kRimLonger * rim);
  if (longer > kClear * longer_open) out.ellipticity = longer;

  const double spread = s2 / square(s) - kRound * (1 + 0.5 * square(longer));
  const double lever = 2 * s2 / s, n = static_cast<double>(patch.count);
  const double levers = sums.s4 - 2 * lever * sums.s3 + (square(lever) + 2 * s2) * sums.s2 -
                        2 * lever * s2 * sums.s + square(s2) * n;
  const double open = std::hypot(noise * std::sqrt(std::max(0.0, levers)) / square(s), kRimKurtosis * rim,
                                 kPointKurtosis * side2);
  if (std::fabs(spread) > kClear * open) out.excess_kurtosis = std::fabs(spread);
  return out;
}

}  // namespace slipd
