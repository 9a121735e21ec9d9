#include "core/estimate/slipping_taxels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slipd {
namespace {

// The share of the load in the slip annulus of a pull with this margin: (1 - k^2)^(3/2), k^3 = Gamma.
double slipping_share(double gamma) noexcept {
  const double k = std::cbrt(gamma), rest = 1 - k * k;
  return rest > 0 ? rest * std::sqrt(rest) : 0;
}

}  // namespace

SlippingTaxels::SlippingTaxels(const TaxelLayout& layout, const SlippingTaxelsOptions& options)
    : options_(options), pressure_pa_(layout.size()), ratio_(layout.size()) {}

// |q| of noise alone is not 0: its square is larger by that of both components.
void SlippingTaxels::collect(const ContactPatch& patch) noexcept {
  noise_normal_pa_ = patch.noise_normal_pa;
  noise_shear_pa_ = patch.noise_shear_pa;
  count_ = 0;
  normal_pa_ = 0;
  bins_.fill(0);
  const double least_pa = std::max(options_.least_sigmas * noise_normal_pa_,
                                   options_.least_share * static_cast<double>(patch.peak_pa));
  const double rectified = 2 * noise_shear_pa_ * noise_shear_pa_;
  const auto every =
      static_cast<std::uint32_t>((patch.count + options_.most_taxels - 1) / options_.most_taxels);
  patch.for_each_inside([&](std::uint32_t i) {
    if (i % every != 0) return;
    const auto p = static_cast<double>(patch.taxels.normal_pa[i]);
    if (!(p > least_pa)) return;
    const auto x = static_cast<double>(patch.taxels.shear_x_pa[i]);
    const auto y = static_cast<double>(patch.taxels.shear_y_pa[i]);
    const double ratio = std::sqrt(std::max(0.0, x * x + y * y - rectified)) / p;
    pressure_pa_[count_] = p;
    ratio_[count_] = ratio;
    ++count_;
    normal_pa_ += p;
    bins_[std::min(kBins - 1, static_cast<std::size_t>(ratio * (kBins / kMostRatio)))] += p;
  });
}

// The ratio below which start_share of the load is.
double SlippingTaxels::start() const noexcept {
  double below_pa = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    below_pa += bins_[bin];
    if (below_pa > options_.start_share * normal_pa_)
      return (static_cast<double>(bin) + 0.5) * kMostRatio / kBins;
  }
  return kMostRatio;
}

// The weighted mean of the taxels within plateau_sigmas of it.
SlippingTaxels::Plateau SlippingTaxels::about(double ratio) const noexcept {
  // A ratio's variance is (sigma_q^2 + ratio^2 sigma_p^2)/p^2, and that of gains.
  const double noise =
      noise_shear_pa_ * noise_shear_pa_ + ratio * ratio * noise_normal_pa_ * noise_normal_pa_;
  const double gain = options_.gain_share * options_.gain_share * ratio * ratio;
  const double within = options_.plateau_sigmas * options_.plateau_sigmas;
  Plateau sums;
  double weighted = 0, by_p = 0, by_pp = 0, by_pr = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const double p = pressure_pa_[i], variance = noise / (p * p) + gain, off = ratio_[i] - ratio;
    if (!(off * off < within * variance)) continue;
    const double weight = 1 / variance;
    weighted += weight * ratio_[i];
    by_p += weight * p;
    by_pp += weight * p * p;
    by_pr += weight * p * off;
    sums.weight += weight;
    sums.width += std::sqrt(weight);
    sums.normal_pa += p;
    ++sums.taxels;
  }
  if (sums.taxels == 0) return sums;
  sums.ratio = weighted / sums.weight;
  sums.width /= sums.weight;
  const double spread = by_pp - by_p * by_p / sums.weight;
  if (spread > 0) {
    sums.slope = (by_pr - by_p * (sums.ratio - ratio)) / spread;
    sums.slope_sigma = 1 / std::sqrt(spread);
  }
  return sums;
}

FrameEstimate SlippingTaxels::estimate(const ContactPatch& loaded) noexcept {
  FrameEstimate out;
  all_slipped_ = false;
  out.turning = true;
  out.friction_sigma = std::numeric_limits<double>::infinity();
  out.center_x_m = loaded.center_x_m;
  out.center_y_m = loaded.center_y_m;
  out.radius_m = loaded.radius_m;
  collect(loaded);
  if (count_ < options_.least_taxels || !(loaded.normal_n > 0)) return out;
  Plateau plateau{.ratio = start()};
  bool settled = false;
  for (int step = 0; step < options_.most_steps && !settled; ++step) {
    const double last = plateau.ratio;
    plateau = about(last);
    if (plateau.taxels < options_.least_taxels || !(plateau.ratio > 0)) return out;
    settled = std::fabs(plateau.ratio - last) < options_.settled_share * last;
  }
  const double mobilised = loaded.shear_n / loaded.normal_n / plateau.ratio;
  out.gamma = std::clamp(1 - mobilised, 0.0, 1.0);
  out.friction = plateau.ratio;
  const double by_noise = options_.noise_factor / (std::sqrt(plateau.weight) * plateau.ratio);
  const double rounded =
      options_.rounded_factor * plateau.width / plateau.ratio * (options_.rounded_base + out.gamma);
  const double sigma = std::hypot(by_noise, rounded);
  const double slipping = plateau.normal_pa / normal_pa_;
  all_slipped_ = slipping > options_.all_slip_share;
  if (out.gamma > options_.max_gamma || plateau.width > options_.max_width * plateau.ratio ||
      plateau.slope < -options_.falling_sigmas * plateau.slope_sigma)
    return out;
  if (!(sigma < options_.max_sigma) || slipping < options_.least_slipping * slipping_share(out.gamma))
    return out;
  out.in_model = true;
  out.friction_sigma = sigma * plateau.ratio;
  out.sigma = mobilised * std::hypot(sigma, loaded.shear_sigma_n / loaded.shear_n);
  out.common_sigma = mobilised * rounded;
  return out;
}

}  // namespace slipd
