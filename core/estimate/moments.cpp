#include "core/estimate/moments.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/patch/rings.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

// Beyond this mean square the rings belong to another history. In the family it is about 1.
constexpr double kMostMisfit = 4;

// The slope of Gamma over the ratio lies between 1 (gross slip) and 9/5 (no load): closed form by k
// (docs/theory.md §7.1).
double slope(double k) noexcept {
  const double k2 = k * k, k3 = k2 * k, rest = 1 - k3;
  if (rest < 1e-6) return 1.8;
  const double d_ratio = (-5 * k2 * rest + 3 * (1 - k2 * k3)) / (rest * rest);  // per k^2
  return 3 / d_ratio;
}

}  // namespace

// Newton's method on (1 - ratio)(1 + k + k^2) + k^3 + k^4 = 0, the ratio's polynomials divided by 1 - k. Its
// only positive root is in (0, 1), and from there on it is convex and rises: from k = 1 each step comes
// nearer without passing it.
double gamma_of_moment_ratio(double ratio) noexcept {
  if (ratio <= 1) return 0;
  if (ratio >= 5.0 / 3) return 1;
  const double rest = 1 - ratio;
  double k = 1;
  for (int i = 0; i < 60; ++i) {
    const double k2 = k * k;
    const double value = rest * (1 + k + k2) + k2 * k + k2 * k2;
    const double step = value / (rest * (1 + 2 * k) + 3 * k2 + 4 * k2 * k);
    if (!(step > 1e-15)) break;
    k -= step;
  }
  return k * k * k;
}

MomentRatio moment_ratio(const ContactPatch& patch, const TaxelLayout& layout) noexcept {
  const MomentSums sums = best_kernels<DiscKernels>().moments(patch.taxels, patch.runs, patch.pose());
  const double unit = patch.radius_m * patch.radius_m, unit2 = unit * unit;
  const double p = sums.p, q = sums.q, p2 = sums.ps * unit, q2 = sums.qs * unit, q4 = sums.qss * unit2;
  const double r2 = sums.s * unit, r4 = sums.s2 * unit2, r6 = sums.s3 * unit2 * unit,
               r8 = sums.s4 * unit2 * unit2;
  MomentRatio out;
  if (!(p > 0 && q > 0)) return out;
  out.load = q / p;
  const double spread = layout.area_m2() / 6;  // a square's own, in each of the sums
  const double mean_p = p2 / p - spread, mean_q = q2 / q - spread;
  if (!(mean_p > 0)) return out;
  out.value = mean_q / mean_p;
  if (patch.cut) return out;
  const auto n = static_cast<double>(patch.count);
  const auto noise = [&](double sigma_pa, double sum, double mean) {
    const double scatter = std::max(0.0, r4 - 2 * mean * r2 + mean * mean * n);
    return sigma_pa * std::sqrt(scatter) / sum;
  };
  const double from_q = noise(patch.noise_shear_pa, q, mean_q),
               from_p = noise(patch.noise_normal_pa, p, mean_p);
  out.deviation = hertz_deviation(sums, patch, layout.side_m());
  const double coarse = layout.side_m() / patch.radius_m;
  const double cut_rim = 0.3 * coarse * coarse * coarse, grid = cut_rim + 0.002;  // of squares on a round rim
  out.sigma = std::hypot(std::hypot(from_q, out.value * from_p) / mean_p, cut_rim + 0.0007);

  // In u = r^2/a^2, with a from the pressure.
  const double a2 = 2.5 * mean_p, side = layout.side_m(), shear_n = patch.shear_n;
  const double u = mean_q / a2;
  const double u2 = (q4 / q - 2.0 / 3 * side * side * mean_q - kSquareFourth * std::pow(side, 4)) / (a2 * a2);
  out.moments = {shear_n * (5.0 / 3 - 2.5 * u), shear_n * (6 * u2 - 6 * u + 1)};
  const double taxel_n = patch.noise_shear_pa * layout.area_m2(), radius = from_p / mean_p;
  const double zero = 5.0 / 3 * mean_p + spread;  // a taxel there counts for nothing
  const double slipped_weights = (r4 - 2 * zero * r2 + zero * zero * n) / (mean_p * mean_p);
  const double hollow_weights =
      36 * r8 / std::pow(a2, 4) - 72 * r6 / std::pow(a2, 3) + 48 * r4 / std::pow(a2, 2) - 12 * r2 / a2 + n;
  out.moments_sigma = {std::hypot(taxel_n * std::sqrt(std::max(0.0, slipped_weights)),
                                  shear_n * std::hypot(2.5 * u * radius, grid)),
                       std::hypot(taxel_n * std::sqrt(std::max(0.0, hollow_weights)),
                                  shear_n * std::hypot((12 * u2 - 6 * u) * radius, 2 * grid))};
  return out;
}

FrameEstimate Moments::estimate(const Frame&, const ContactPatch& patch) noexcept {
  return estimate(patch, sum_rings(patch, layout_));
}

FrameEstimate Moments::estimate(const ContactPatch& patch, const Rings& rings) const noexcept {
  FrameEstimate out;
  out.center_x_m = patch.center_x_m;
  out.center_y_m = patch.center_y_m;
  out.radius_m = patch.radius_m;
  const MomentRatio ratio = moment_ratio(patch, layout_);
  out.moments = ratio.moments;
  out.moments_sigma = ratio.moments_sigma;
  const double open = 3 * ratio.sigma + 0.03;
  if (!std::isfinite(ratio.sigma) || ratio.value < 1 - open || ratio.value > 5.0 / 3 + open) return out;
  out.gamma = gamma_of_moment_ratio(ratio.value);
  out.sigma = std::hypot(slope(std::cbrt(out.gamma)) * ratio.sigma, ratio.deviation.sigma());
  const double held = std::max(1e-6, 1 - out.gamma);
  out.friction = ratio.load / held;
  // Near no load friction is a ratio of two small numbers.
  out.friction_sigma = out.sigma < 0.5 * held
                           ? out.friction * std::hypot(out.sigma / held, patch.shear_sigma_n / patch.shear_n)
                           : std::numeric_limits<double>::infinity();
  out.in_model = ratio.deviation.hertzian() &&
                 monotonic_misfit(rings, patch, layout_, out.gamma, out.friction) < kMostMisfit;
  return out;
}

}  // namespace slipd
