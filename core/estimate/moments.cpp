#include "core/estimate/moments.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/patch/rings.hpp"

namespace slipd {
namespace {

// Beyond this mean square the rings belong to another history. In the family it is about 1.
constexpr double kMostMisfit = 4;

// The slope of Gamma over the ratio lies between 1 (gross slip) and 9/5 (no load): closed form by k.
double slope(double k) noexcept {
  const double k2 = k * k, k3 = k2 * k, rest = 1 - k3;
  if (rest < 1e-6) return 1.8;
  const double d_ratio = (-5 * k2 * rest + 3 * (1 - k2 * k3)) / (rest * rest);  // per k^2
  return 3 / d_ratio;
}

}  // namespace

double gamma_of_moment_ratio(double ratio) noexcept {
  if (ratio <= 1) return 0;
  if (ratio >= 5.0 / 3) return 1;
  double low = 0, high = 1;
  for (int i = 0; i < 50; ++i) {
    const double k = 0.5 * (low + high), k2 = k * k;
    // (1 - k^5)/(1 - k^3), both divided by 1 - k.
    const double value = (1 + k + k2 + k2 * k + k2 * k2) / (1 + k + k2);
    (value < ratio ? low : high) = k;
  }
  const double k = 0.5 * (low + high);
  return k * k * k;
}

Reading Moments::read(const Frame& frame, const ContactPatch& patch) noexcept {
  double p = 0, q = 0, p2 = 0, q2 = 0, r4 = 0, r2 = 0;
  for (const std::uint32_t i : patch.inside) {
    const double x = layout_.x_m()[i] - patch.center_x_m, y = layout_.y_m()[i] - patch.center_y_m;
    const double square = x * x + y * y, normal = frame.normal_pa[i], shear = patch.shear_along_pa(frame, i);
    p += normal;
    q += shear;
    p2 += normal * square;
    q2 += shear * square;
    r2 += square;
    r4 += square * square;
  }
  Reading out;
  out.center_x_m = patch.center_x_m;
  out.center_y_m = patch.center_y_m;
  out.radius_m = patch.radius_m;
  if (!(p > 0 && q > 0) || patch.cut) return out;

  const Rings rings = sum_rings(frame, patch, layout_);
  out.rim = read_rim(rings, patch, layout_);
  const double spread = layout_.area_m2() / 6;  // a square's own, in each of the sums
  const double mean_p = p2 / p - spread, mean_q = q2 / q - spread;
  if (!(mean_p > 0)) return out;
  const double ratio = mean_q / mean_p;
  const auto n = static_cast<double>(patch.inside.size());
  const auto noise = [&](double sigma_pa, double sum, double mean) {
    const double scatter = std::max(0.0, r4 - 2 * mean * r2 + mean * mean * n);
    return sigma_pa * std::sqrt(scatter) / sum;
  };
  const double from_q = noise(patch.noise_shear_pa, q, mean_q),
               from_p = noise(patch.noise_normal_pa, p, mean_p);
  const double coarse = layout_.side_m() / patch.radius_m;
  const double ratio_sigma =
      std::hypot(from_q, ratio * from_p) / mean_p + 0.3 * coarse * coarse * coarse + 0.002;

  const double open = 3 * ratio_sigma + 0.03;
  if (ratio < 1 - open || ratio > 5.0 / 3 + open) return out;
  out.gamma = gamma_of_moment_ratio(ratio);
  out.sigma = slope(std::cbrt(out.gamma)) * ratio_sigma;
  const double load = std::max(1e-6, 1 - out.gamma);
  out.friction = q / p / load;
  // Near no load friction is a ratio of two small numbers.
  out.friction_sigma =
      out.sigma < 0.5 * load
          ? out.friction * std::hypot(out.sigma / load, patch.noise_shear_pa * std::sqrt(n) / q)
          : std::numeric_limits<double>::infinity();
  out.in_family = family_misfit(rings, patch, layout_, out.gamma, out.friction) < kMostMisfit;
  return out;
}

}  // namespace slipd
