#include "core/reading/torque/torque_moment_ratio.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"
#include "core/reading/method/friction_prior.hpp"
#include "core/reading/moments/moments.hpp"
#include "core/reading/torque/torque_kernels.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

// Sums over taxels of w, w s and w s^2, s = r^2/a^2.
struct Levers {
  double all = 0, first = 0, second = 0;

  explicit Levers(const double (&sums)[3]) noexcept : all(sums[0]), first(sums[1]), second(sums[2]) {}
  double mean() const noexcept { return first / all; }
  // <s> and <s^2> without what squares of area `area`, in units of a^2, spread them by (5.4).
  double mean(double area) const noexcept { return mean() - area / 6; }
  double mean_square(double area) const noexcept {
    return second / all - 2.0 / 3 * area * mean(area) - kSquareFourth * area * area;
  }
  // Of squares about a mean.
  double about(double mean) const noexcept {
    return std::max(0.0, second - 2 * mean * first + mean * mean * all);
  }
};

}  // namespace

TorqueMomentRatio::TorqueMomentRatio(const TaxelLayout& layout, const TorqueMomentRatioOptions& options)
    : options_(options), side_m_(layout.side_m()), area_m2_(layout.area_m2()) {}

// Moments of q.v over those of p|v|, v the motion in which the object would slide.
TorqueMomentRatio::Ratio TorqueMomentRatio::ratio_of(const ContactPatch& patch, double along,
                                                     double spin) const noexcept {
  const double scale = 1 / patch.radius_m;
  const TorqueSums sums = best_kernels<TorqueKernels>().turning(
      patch.taxels, patch.runs, patch.pose(),
      {.along = static_cast<float>(along), .spin = static_cast<float>(spin)});
  const Levers work(sums.work), limit(sums.limit), speeds(sums.speeds);
  if (!(work.all > 0 && limit.all > 0)) return {};
  const double area = area_m2_ * scale * scale, of_limit = limit.mean(area);
  if (!(of_limit > 0)) return {};
  const double value = work.mean(area) / of_limit;
  const double from_q = patch.noise_shear_pa * std::sqrt(speeds.about(work.mean())) / work.all;
  const double from_p = patch.noise_normal_pa * std::sqrt(speeds.about(limit.mean())) / limit.all;
  return {.value = value,
          .noise = norm(from_q, value * from_p) / of_limit,
          .fourth = work.mean_square(area) / limit.mean_square(area)};
}

// What a pull with the same margin would have. A contact that sticks all over has 5/3 under a pull and 8/5
// under a torque, one that slides has 1 under both; the excess over 1 of the fourth moments is 4/3 and 1.19.
TorqueMomentRatio::Ratio TorqueMomentRatio::as_of_pull(const Ratio& ratio, double spin_share) noexcept {
  constexpr double kSticks = 8.0 / 5 - 1, kMoreUnderPull = (5.0 / 3 - 1) / kSticks - 1;
  const double more = 1 + kMoreUnderPull * spin_share * spin_share * (ratio.value - 1) / kSticks;
  return {.value = 1 + (ratio.value - 1) * more,
          .noise = ratio.noise * more,
          .fourth = 1 + (ratio.fourth - 1) * more};
}

// By (3.1) the fourth moments have the ratio (1 - k^7)/(1 - k^3), but for noise, square taxels and the skin.
bool TorqueMomentRatio::half_space(const Ratio& ratio, double gamma, double coarse) const noexcept {
  constexpr double kNoLoad = 1e-6;
  const double k = std::cbrt(gamma), rest = 1 - gamma;
  const double expected = rest > kNoLoad ? (1 - gamma * gamma * k) / rest : 7.0 / 3;
  return std::fabs(ratio.fourth - expected) <
         options_.fourth_slack + kCoarseTorque * coarse * coarse + kClearSigmas * ratio.noise;
}

Reading TorqueMomentRatio::estimate(const ContactPatch& loaded,
                                    const EquivalentPullResult& load) const noexcept {
  Reading out;
  out.under_torque = true;
  out.friction_sigma = std::numeric_limits<double>::infinity();
  out.center_x_m = loaded.center_x_m;
  out.center_y_m = loaded.center_y_m;
  out.radius_m = loaded.radius_m;
  const double along = load.along_per_n, spin = load.spin_per_nm * loaded.radius_m;
  const double coarse = side_m_ / loaded.radius_m;
  if (loaded.cut || !(std::fabs(spin) + along > 0)) return out;
  const HertzDeviation deviation =
      hertz_deviation(best_kernels<DiscKernels>().moments(loaded.taxels, loaded.runs, loaded.pose()), loaded,
                      side_m_, options_.deviation);
  const Ratio ratio = as_of_pull(ratio_of(loaded, along, spin), std::fabs(spin) / (std::fabs(spin) + along));
  const double common = options_.ratio_floor + kCoarseTorque * coarse * coarse;
  const double open = kClearSigmas * norm(ratio.noise, common);
  if (!(ratio.value > 1 - open) || !(ratio.noise < options_.max_noise) ||
      !deviation.hertzian(options_.deviation))
    return out;
  out.gamma = gamma_of_moment_ratio(ratio.value);
  if (!half_space(ratio, out.gamma, coarse)) return out;
  if (coarse < options_.least_coarse && out.gamma < kRoundedGamma) return out;
  const double slope = gamma_per_moment_ratio(std::cbrt(out.gamma)),
               of_shape = deviation.sigma(options_.deviation);
  out.sigma = norm(slope * norm(ratio.noise, common), of_shape);
  out.common_sigma = norm(slope * common, of_shape);
  // A margin lies below 1: no nearer to it than what noise may be of it.
  out.gamma = std::min(out.gamma, 1 - out.sigma);
  const double utilisation = 1 - out.gamma, relative = out.sigma / utilisation;
  if (!(out.sigma < std::max(kKnownFriction * utilisation, kSettledFriction))) return out;
  out.friction = loaded.shear_n / loaded.normal_n / utilisation;
  if (relative < kSettledFriction)
    out.friction_sigma = out.friction * norm(relative, loaded.shear_sigma_n / loaded.shear_n);
  out.in_model = true;
  return out;
}

}  // namespace slipd
