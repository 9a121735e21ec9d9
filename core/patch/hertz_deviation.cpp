#include "core/patch/hertz_deviation.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

double square(double x) noexcept {
  return x * x;
}

// <x (x^2 + y^2)>, about the centroid, is 0 of a round contact and -8/175 t a^3 of a tilted one. Noise moves
// the centroid, too, and by that 4/5 of its own lever.
double tilt_of(const MomentSums& sums, const ContactPatch& patch, double rim,
               const HertzDeviationOptions& options) noexcept {
  constexpr double kPerTilt = 8.0 / 175, kCentroid = 0.8;
  const double unit = 1 / (kPerTilt * patch.radius_m * sums.p);
  const double levers = sums.s3 - 2 * kCentroid * sums.s2 + square(kCentroid) * sums.s;
  const double noise = patch.noise_normal_pa / (kPerTilt * sums.p);
  const double variance = 0.5 * square(noise) * std::max(0.0, levers) + square(options.rim * rim);
  const double squares = square(unit * sums.psx) + square(unit * sums.psy);
  return squares > square(kClearSigmas) * variance ? std::sqrt(squares - 2 * variance) : 0;
}

}  // namespace

bool HertzDeviation::hertzian(const HertzDeviationOptions& options) const noexcept {
  return excess_kurtosis < options.max_kurtosis && ellipticity < options.max_ellipticity;
}

double HertzDeviation::sigma(const HertzDeviationOptions& options) const noexcept {
  constexpr double kHalfTilt = 0.5;  // costs half of what a large tilt does
  return kFarSigma * std::hypot(tilt / (kHalfTilt + tilt), square(ellipticity / options.max_ellipticity),
                                excess_kurtosis / options.max_kurtosis);
}

// <r^4>/<r^2>^2 of the pressure is 10/7 of a round contact, and half the square of its ellipticity more, as a
// share, of an elliptic one. What a skin that spreads stress adds is the excess.
HertzDeviation hertz_deviation(const MomentSums& sums, const ContactPatch& patch, double side_m,
                               const HertzDeviationOptions& options) noexcept {
  constexpr double kRound = 10.0 / 7;
  HertzDeviation out;
  const double side2 = square(side_m / patch.radius_m), rim = side2 * side_m / patch.radius_m;
  out.tilt = tilt_of(sums, patch, rim, options);
  const double s = sums.ps / sums.p - side2 / 6,
               s2 = sums.pss / sums.p - 2.0 / 3 * side2 * s - kSquareFourth * square(side2);
  if (!(s > 0)) return out;
  const double noise = patch.noise_normal_pa / sums.p;
  const double ellipticity = norm(sums.px2y2, 2 * sums.pxy) / (sums.p * s);
  const double ellipticity_sigma = norm(noise * std::sqrt(0.5 * sums.s2) / s, kRimShare * rim);
  if (ellipticity > kClearSigmas * ellipticity_sigma) {
    out.ellipticity = ellipticity;
    out.long_axis_rad = 0.5 * std::atan2(2 * sums.pxy, sums.px2y2);
  }

  const double excess = s2 / square(s) - kRound * (1 + 0.5 * square(ellipticity));
  const double lever = 2 * s2 / s, n = static_cast<double>(patch.count);
  const double levers = sums.s4 - 2 * lever * sums.s3 + (square(lever) + 2 * s2) * sums.s2 -
                        2 * lever * s2 * sums.s + square(s2) * n;
  const double excess_sigma = std::hypot(noise * std::sqrt(std::max(0.0, levers)) / square(s),
                                         options.rim * rim, options.point_kurtosis * side2);
  if (std::fabs(excess) > kClearSigmas * excess_sigma) out.excess_kurtosis = std::fabs(excess);
  return out;
}

}  // namespace slipd
