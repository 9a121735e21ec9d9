#include "core/reading/moments/moments.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"
#include "core/patch/rings.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/moments/grid_aliasing.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

// What noise of each taxel makes of <r^2>: sqrt(sum (r^2 - mean)^2) over the sum of what it is weighted by.
double noise_of_mean(double sigma_pa, double sum_pa, double mean, double r2, double r4, double n) noexcept {
  const double scatter = std::max(0.0, r4 - 2 * mean * r2 + mean * mean * n);
  return sigma_pa * std::sqrt(scatter) / sum_pa;
}

}  // namespace

// Newton's method on (1 - ratio)(1 + k + k^2) + k^3 + k^4 = 0, the ratio's polynomials divided by 1 - k. Its
// only positive root is in (0, 1), and from there on it is convex and rises: from k = 1 each step comes
// nearer without passing it.
double gamma_of_moment_ratio(double ratio) noexcept {
  constexpr int kMaxSteps = 60;      // more than any ratio takes
  constexpr double kNoStep = 1e-15;  // of k: rounding is as large
  if (ratio <= 1) return 0;
  if (ratio >= 5.0 / 3) return 1;
  const double rest = 1 - ratio;
  double k = 1;
  for (int i = 0; i < kMaxSteps; ++i) {
    const double k2 = k * k;
    const double value = rest * (1 + k + k2) + k2 * k + k2 * k2;
    const double step = value / (rest * (1 + 2 * k) + 3 * k2 + 4 * k2 * k);
    if (!(step > kNoStep)) break;
    k -= step;
  }
  return k * k * k;
}

double gamma_per_moment_ratio(double k) noexcept {
  constexpr double kNoLoad = 1e-6;  // of 1 - Gamma: below it the closed form is 0/0, and its limit holds
  const double k2 = k * k, k3 = k2 * k, rest = 1 - k3;
  if (rest < kNoLoad) return 9.0 / 5;
  const double d_ratio = (-5 * k2 * rest + 3 * (1 - k2 * k3)) / (rest * rest);  // per k^2
  return 3 / d_ratio;
}

namespace {

// What taxels make of a ring of shear at the rim. `coarse`: side/a.
double ring_error(double coarse, double gamma, const MomentRatioOptions& options) noexcept {
  const double widths = (1 - std::cbrt(gamma)) / (options.ring_width * coarse), widths2 = widths * widths;
  return options.rim_error * coarse * coarse / (1 + widths2 * widths2);
}

}  // namespace

MomentRatio moment_ratio(const ContactPatch& patch, const TaxelLayout& layout,
                         const MomentRatioOptions& options) noexcept {
  const MomentSums sums = best_kernels<DiscKernels>().moments(patch.taxels, patch.runs, patch.pose());
  const double unit = patch.radius_m * patch.radius_m, unit2 = unit * unit;
  const double p = sums.p, q = sums.q, p2 = sums.ps * unit, q2 = sums.qs * unit, q4 = sums.qss * unit2;
  const double r2 = sums.s * unit, r4 = sums.s2 * unit2, r6 = sums.s3 * unit2 * unit,
               r8 = sums.s4 * unit2 * unit2;
  MomentRatio out;
  if (!(p > 0 && q > 0)) return out;
  out.load = q / p;
  const double spread = layout.area_m2() / 6;  // a square's own <r^2>, in each of the sums
  const bool corrected = layout.regular().has_value() && patch.interpolated == 0;
  const GridAliasing aliasing(layout.side_m(), patch.center_x_m - layout.x_m()[0],
                              patch.center_y_m - layout.y_m()[0]);
  const double mean_p = p2 / p - spread, mean_q = q2 / q - spread;
  if (!(mean_p > 0)) return out;
  out.value = mean_q / mean_p;
  if (patch.cut) return out;
  const auto n = static_cast<double>(patch.count);
  const double from_q = noise_of_mean(patch.noise_shear_pa, q, mean_q, r2, r4, n),
               from_p = noise_of_mean(patch.noise_normal_pa, p, mean_p, r2, r4, n);
  out.deviation = hertz_deviation(sums, patch, layout.side_m(), options.deviation);
  out.gamma = gamma_of_moment_ratio(out.value);
  if (corrected) {
    constexpr int kRounds = 2;  // the correction depends on Gamma by much less than Gamma's own range
    const double dome_m2 = mean_p - aliasing.of_dome_m2(patch.radius_m), radius_m = std::sqrt(2.5 * dome_m2);
    for (int round = 0; round < kRounds; ++round) {
      out.value = (mean_q - aliasing.of_shear_m2(radius_m, out.gamma)) / dome_m2;
      out.gamma = gamma_of_moment_ratio(out.value);
    }
  }
  const double coarse = layout.side_m() / patch.radius_m;
  const double rim =
                   norm(options.rim_error * coarse * coarse * coarse, ring_error(coarse, out.gamma, options)),
               grid = rim + options.moments_floor;
  out.common_sigma = (corrected ? options.corrected_share : 1) * rim + kExactShare;
  out.sigma = norm(norm(from_q, out.value * from_p) / mean_p, out.common_sigma);

  // In u = r^2/a^2, with a from the pressure, <r^2>_p = 2 a^2/5: the slip moment Q (5/3 - 5/2 <u>) and the
  // second Legendre moment Q <6 u^2 - 6 u + 1>, and what noise and a wrong radius make of both.
  const double a2 = 2.5 * mean_p, side = layout.side_m(), shear_n = patch.shear_n;
  const double u = mean_q / a2;
  const double u2 =
      (q4 / q - 2.0 / 3 * side * side * mean_q - kSquareFourth * side * side * side * side) / (a2 * a2);
  out.moments = {shear_n * (5.0 / 3 - 2.5 * u), shear_n * (6 * u2 - 6 * u + 1)};
  const double taxel_n = patch.noise_shear_pa * layout.area_m2(), radius = from_p / mean_p;
  const double zero = 5.0 / 3 * mean_p + spread;  // a taxel there counts for nothing
  const double slip_weights = (r4 - 2 * zero * r2 + zero * zero * n) / (mean_p * mean_p);
  const double legendre_weights = (((36 * r8 / a2 - 72 * r6) / a2 + 48 * r4) / a2 - 12 * r2) / a2 + n;
  out.moments_sigma = {
      norm(taxel_n * std::sqrt(std::max(0.0, slip_weights)), shear_n * norm(2.5 * u * radius, grid)),
      norm(taxel_n * std::sqrt(std::max(0.0, legendre_weights)),
           shear_n * norm((12 * u2 - 6 * u) * radius, 2 * grid))};
  out.moments_common_sigma = {shear_n * grid, 2 * shear_n * grid};
  return out;
}

Reading Moments::estimate(const Frame&, const ContactPatch& patch) noexcept {
  return estimate(patch, sum_rings(patch, layout_));
}

Reading Moments::estimate(const ContactPatch& patch, const Rings& rings) const noexcept {
  constexpr double kNoShear = 1e-6;  // of 1 - Gamma: keeps friction finite without shear
  Reading out;
  out.center_x_m = patch.center_x_m;
  out.center_y_m = patch.center_y_m;
  out.radius_m = patch.radius_m;
  const MomentRatio ratio = moment_ratio(patch, layout_, options_);
  out.moments = ratio.moments;
  out.moments_sigma = ratio.moments_sigma;
  out.moments_common_sigma = ratio.moments_common_sigma;
  const double open = kClearSigmas * ratio.sigma;  // more is no monotonic load's
  if (!std::isfinite(ratio.sigma) || ratio.value < 1 - open || ratio.value > 5.0 / 3 + open) return out;
  out.gamma = ratio.gamma;
  const double per_ratio = gamma_per_moment_ratio(std::cbrt(out.gamma)),
               deviation = ratio.deviation.sigma(options_.deviation);
  out.sigma = norm(per_ratio * ratio.sigma, deviation);
  out.common_sigma = norm(per_ratio * ratio.common_sigma, deviation);
  const double utilisation = std::max(kNoShear, 1 - out.gamma);
  out.friction = ratio.load / utilisation;
  out.friction_sigma = out.sigma < kKnownFrictionShare * utilisation
                           ? out.friction * norm(out.sigma / utilisation, patch.shear_sigma_n / patch.shear_n)
                           : std::numeric_limits<double>::infinity();
  out.in_model = ratio.deviation.hertzian(options_.deviation) &&
                 monotonic_misfit(rings, patch, layout_, out.gamma, out.friction) < kMaxRingMisfit;
  return out;
}

}  // namespace slipd
