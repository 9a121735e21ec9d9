#include "core/reading/torque/friction_plateau.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/frame/few_taxels.hpp"
#include "core/frame/significance.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/iteration.hpp"
#include "core/numeric/norm.hpp"
#include "core/reading/method/friction_prior.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

// The share of the load in the slip annulus of a pull with this margin: (1 - k^2)^(3/2), k^3 = Gamma.
double slipping_share(double gamma) noexcept {
  const double k = std::cbrt(gamma), rest = 1 - k * k;
  return rest > 0 ? rest * std::sqrt(rest) : 0;
}

// Values that the lists of ratios may have: each run ends with a block that is not full.
std::size_t room_for(const TaxelLayout& layout) {
  const std::size_t runs = layout.regular() ? layout.regular()->rows : layout.size();
  return layout.size() + runs * kMaxLanes;
}

}  // namespace

FrictionPlateau::FrictionPlateau(const TaxelLayout& layout, const FrictionPlateauOptions& options)
    : options_(options),
      kernels_(best_kernels<TorqueKernels>()),
      rows_(layout.regular().has_value()),
      pressure_pa_(room_for(layout)),
      ratio_(room_for(layout)) {}

// |q| of noise alone is not 0: its square is larger by that of both components.
void FrictionPlateau::collect(const ContactPatch& patch) noexcept {
  frame_.noise_normal_pa = patch.noise_normal_pa;
  frame_.noise_shear_pa = patch.noise_shear_pa;
  const double least_pa = std::max(kStandsOutSigmas * frame_.noise_normal_pa,
                                   options_.least_share * static_cast<double>(patch.peak_pa));
  const RatioTest test{
      .least_pa = static_cast<float>(least_pa),
      .rectified_pa2 = static_cast<float>(2 * frame_.noise_shear_pa * frame_.noise_shear_pa)};
  const std::size_t every = rows_ ? (patch.count + options_.most_taxels - 1) / options_.most_taxels : 1;
  const RatioSums sums = kernels_.ratios(patch.taxels, patch.runs, std::max<std::size_t>(1, every), test,
                                         pressure_pa_.data(), ratio_.data());
  frame_.stored = sums.stored;
  frame_.count = sums.taxels;
  frame_.normal_pa = sums.normal_pa;
}

// The ratio below which start_share of the load is, within half a step.
double FrictionPlateau::start() const noexcept {
  const double wanted_pa = options_.start_share * frame_.normal_pa;
  double low = 0, high = kMostRatio;
  while (high - low > kStartStep) {
    const double middle = (low + high) / 2;
    const double below_pa =
        kernels_.below(pressure_pa_.data(), ratio_.data(), frame_.stored, static_cast<float>(middle));
    (below_pa > wanted_pa ? high : low) = middle;
  }
  return (low + high) / 2;
}

// A ratio's variance is (sigma_q^2 + ratio^2 sigma_p^2)/p^2, and that of gains.
PlateauTest FrictionPlateau::test_about(double ratio) const noexcept {
  const double noise_pa2 = frame_.noise_shear_pa * frame_.noise_shear_pa +
                           ratio * ratio * frame_.noise_normal_pa * frame_.noise_normal_pa;
  return {.ratio = static_cast<float>(ratio),
          .noise_pa2 = static_cast<float>(noise_pa2),
          .gain = static_cast<float>(options_.gain_share * options_.gain_share * ratio * ratio),
          .within = static_cast<float>(kAlikeSigmas * kAlikeSigmas)};
}

// The mean of the taxels within kAlikeSigmas of a ratio, moved there until it stands.
FrictionPlateau::Plateau FrictionPlateau::find_plateau() const noexcept {
  double ratio = start(), last = ratio;
  for (int step = 0; step < kMostSteps; ++step) {
    last = ratio;
    const PlateauSums sums =
        kernels_.near(pressure_pa_.data(), ratio_.data(), frame_.stored, test_about(last));
    if (sums.taxels < kFewInside) return {};
    ratio = last + sums.off / sums.weight;
    if (!(ratio > 0)) return {};
    if (std::fabs(ratio - last) < kSettled * last) break;
  }
  const PlateauSums sums =
      kernels_.plateau(pressure_pa_.data(), ratio_.data(), frame_.stored, test_about(last));
  Plateau plateau{.ratio = ratio,
                  .weight = sums.weight,
                  .width = sums.width / sums.weight,
                  .normal_pa = sums.normal_pa,
                  .taxels = sums.taxels};
  const double spread = sums.pp - sums.p * sums.p / sums.weight;
  if (spread > 0) {
    plateau.slope = (sums.p_off - sums.p * (plateau.ratio - last)) / spread;
    plateau.slope_sigma = 1 / std::sqrt(spread);
  }
  return plateau;
}

void FrictionPlateau::follow_slope(double sigmas) noexcept {
  slope_.frames += 1;
  slope_.mean += std::max(kSlowGain, 1 / slope_.frames) * (sigmas - slope_.mean);
}

Reading FrictionPlateau::estimate(const ContactPatch& loaded) noexcept {
  Reading out;
  frame_ = {};
  out.under_torque = true;
  out.friction_sigma = std::numeric_limits<double>::infinity();
  out.center_x_m = loaded.center_x_m;
  out.center_y_m = loaded.center_y_m;
  out.radius_m = loaded.radius_m;
  collect(loaded);
  if (frame_.count < kFewInside || !(loaded.normal_n > 0)) return out;
  const Plateau plateau = find_plateau();
  if (plateau.taxels < kFewInside) return out;
  if (plateau.slope_sigma > 0) follow_slope(plateau.slope / plateau.slope_sigma);
  const double utilisation = loaded.shear_n / loaded.normal_n / plateau.ratio;
  out.gamma = std::clamp(1 - utilisation, 0.0, 1.0);
  out.friction = plateau.ratio;
  const double by_noise = options_.noise_factor / (std::sqrt(plateau.weight) * plateau.ratio);
  const double square = out.gamma * out.gamma;
  const double rounded = options_.noise_factor * plateau.width / plateau.ratio *
                         (options_.rounded_base + out.gamma + options_.rounded_steep * square * square);
  const double sigma = norm(by_noise, rounded);
  const double slipping = plateau.normal_pa / frame_.normal_pa;
  frame_.all_slipped = slipping > kWhole;
  if (out.gamma > options_.max_gamma || plateau.width > kSettledFriction * plateau.ratio ||
      plateau.slope < -kClearSigmas * plateau.slope_sigma)
    return out;
  if (!(sigma < kSettledFriction) || slipping < options_.least_slipping * slipping_share(out.gamma))
    return out;
  out.in_model = true;
  out.friction_sigma = sigma * plateau.ratio;
  out.sigma = utilisation * norm(sigma, loaded.shear_sigma_n / loaded.shear_n);
  out.common_sigma = utilisation * rounded;
  return out;
}

}  // namespace slipd
