#include "core/estimate/closing.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace slipd {

Closing::Closing(const TaxelLayout& layout, Range friction_expected, const ClosingOptions& options)
    : layout_(layout),
      prior_{.expected = friction_expected, .spread = options.prior.scene_spread},
      options_(options),
      maps_(layout.size()),
      shear_pa_(layout.size()) {}

void Closing::observe(const Frame&, const ContactPatch& patch) noexcept {
  if (!(patch.normal_n > 0) || patch.normal_n < options_.least_force_sigmas * patch.normal_sigma_n) return;
  if (patch.shear_n > options_.most_shear * patch.normal_n &&
      patch.shear_n > options_.most_shear_sigmas * patch.shear_sigma_n)
    return;
  if (maps_.frames_like(patch.normal_n) >= options_.enough_frames) return;
  maps_.add({patch.taxels.normal_pa, layout_.size()}, patch.normal_n);
}

bool Closing::recorded(const ContactPatch& patch) const noexcept {
  return maps_.size() >= options_.least_maps &&
         maps_.force_n(0) <= options_.most_first_force * patch.normal_n &&
         patch.normal_n <= options_.most_growth * maps_.force_n(maps_.size() - 1);
}

bool Closing::unmoved(const ContactPatch& patch, const ClosingMaps::Sum& today) const noexcept {
  const std::span<const float> pressure(patch.taxels.normal_pa, layout_.size());
  const double noise_pa2 = patch.noise_normal_pa * patch.noise_normal_pa;
  double square_pa2 = 0;
  for (const float value : pressure) square_pa2 += static_cast<double>(value) * value;
  square_pa2 -= static_cast<double>(layout_.size()) * noise_pa2;
  const double map_pa2 = maps_.square_pa2(today, patch.noise_normal_pa);
  const double product_pa2 = ClosingMaps::product(today, maps_.products(pressure));
  if (!(square_pa2 > 0 && map_pa2 > 0)) return false;
  return 1 - product_pa2 * product_pa2 / (square_pa2 * map_pa2) < options_.most_unlike;
}

Closing::Trial Closing::judge(double gamma, const ContactPatch& patch, const ClosingMaps::Sum& today,
                              const ClosingMaps::PerMap& products, double shear_square_pa2) const noexcept {
  const ClosingMaps::Sum slipping = ClosingMaps::difference(today, maps_.at(gamma * patch.normal_n));
  const double product_pa2 = ClosingMaps::product(slipping, products);
  const double square_pa2 = maps_.square_pa2(slipping, patch.noise_normal_pa);
  Trial trial{.gamma = gamma};
  if (!(product_pa2 > 0 && square_pa2 > 0)) return trial;
  trial.friction = product_pa2 / square_pa2;
  const double shear_pa2 = patch.noise_shear_pa * patch.noise_shear_pa;
  const double map_pa = trial.friction * patch.noise_normal_pa;
  const double noise_share = maps_.noise_share(slipping), map_pa2 = map_pa * map_pa * noise_share;
  trial.noise_pa2 = std::max(shear_pa2 + map_pa2, std::numeric_limits<double>::min());
  trial.map_share = map_pa2 / trial.noise_pa2;
  const auto taxels = static_cast<double>(layout_.size());
  // Of the maps as they are, with their noise.
  const double noisy_pa2 = square_pa2 + taxels * patch.noise_normal_pa * patch.noise_normal_pa * noise_share;
  trial.residual_pa2 = std::max(
      0.0, shear_square_pa2 - 2 * trial.friction * product_pa2 + trial.friction * trial.friction * noisy_pa2);
  trial.misfit = 0.5 * (trial.residual_pa2 / trial.noise_pa2 + taxels * std::log(trial.noise_pa2));
  trial.nats = prior_.nats_against(trial.friction);
  return trial;
}

// Means over the likelihood of all margins: it need not be a parabola.
void Closing::weigh(FrameEstimate& out) const noexcept {
  double least = std::numeric_limits<double>::infinity();
  for (const Trial& trial : trials_) {
    if (trial.friction > 0) least = std::min(least, trial.misfit + trial.nats);
  }
  double weights = 0, mean = 0, square = 0, friction = 0, friction_square = 0;
  for (const Trial& trial : trials_) {
    if (trial.friction <= 0) continue;
    const double weight = std::exp(least - trial.misfit - trial.nats);
    weights += weight;
    mean += weight * trial.gamma;
    square += weight * trial.gamma * trial.gamma;
    friction += weight * trial.friction;
    friction_square += weight * trial.friction * trial.friction;
  }
  if (!(weights > 0)) return;
  out.in_model = true;
  out.gamma = mean / weights;
  out.sigma = std::sqrt(std::max(0.0, square / weights - out.gamma * out.gamma));
  out.friction = friction / weights;
  out.friction_sigma = std::sqrt(std::max(0.0, friction_square / weights - out.friction * out.friction));
}

// Without the prior.
void Closing::give_profile(FrameEstimate& out) const noexcept {
  constexpr double kNone = 50;  // nats against a margin that would need a friction below 0
  double least = std::numeric_limits<double>::infinity();
  for (const Trial& trial : trials_) {
    if (trial.friction > 0) least = std::min(least, trial.misfit);
  }
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    const Trial& trial = trials_[kStepsOfProfile * j + kStepsOfProfile / 2];
    out.profile.misfit[j] = trial.friction > 0 ? std::min(kNone, trial.misfit - least) : kNone;
  }
  out.profile.known = true;
}

FrameEstimate Closing::estimate(const Frame&, const ContactPatch& patch) noexcept {
  FrameEstimate out;
  if (!recorded(patch)) return out;
  const ClosingMaps::Sum today = maps_.at(patch.normal_n);
  if (!unmoved(patch, today)) return out;
  double shear_square_pa2 = 0, across_pa2 = 0;
  for (std::uint32_t i = 0; i < layout_.size(); ++i) {
    shear_pa_[i] = static_cast<float>(patch.shear_along_pa(i));
    shear_square_pa2 += static_cast<double>(shear_pa_[i]) * shear_pa_[i];
    const double across_pa =
        patch.direction_x * patch.taxels.shear_y_pa[i] - patch.direction_y * patch.taxels.shear_x_pa[i];
    across_pa2 += across_pa * across_pa;
  }
  const ClosingMaps::PerMap products = maps_.products(shear_pa_);
  const Trial* best = nullptr;
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double gamma = (static_cast<double>(i) + 0.5) / kSteps;
    trials_[i] = judge(gamma, patch, today, products, shear_square_pa2);
    if (trials_[i].friction > 0 && (best == nullptr || trials_[i].misfit < best->misfit)) best = &trials_[i];
  }
  if (best == nullptr) return out;
  const auto taxels = static_cast<double>(layout_.size());
  // Shear across the pull is none of a load that came in one direction.
  across_pa2 = std::max(0.0, across_pa2 - taxels * patch.noise_shear_pa * patch.noise_shear_pa);
  const double excess_pa2 = best->residual_pa2 - best->noise_pa2 * taxels + across_pa2;
  const bool clear = excess_pa2 > options_.clear_sigmas * best->noise_pa2 * std::sqrt(2 * taxels);
  const double explained_pa2 = shear_square_pa2 - best->residual_pa2;
  const double unexplained = clear ? std::sqrt(excess_pa2 / std::max(explained_pa2, excess_pa2)) : 0;
  if (unexplained > options_.most_unexplained) return out;
  weigh(out);
  if (!out.in_model) return out;
  if (out.sigma > options_.open_sigma) give_profile(out);
  const double by_model = std::hypot(options_.least_sigma, options_.unexplained_sigma * unexplained);
  out.common_sigma = std::hypot(by_model, out.sigma * std::sqrt(best->map_share));
  out.sigma = std::hypot(out.sigma, by_model);
  const double rest = 1 - out.gamma;
  if (!(out.sigma < options_.max_friction_share * rest))
    out.friction_sigma = std::numeric_limits<double>::infinity();
  else
    out.friction_sigma = std::hypot(out.friction_sigma, out.friction * by_model / rest);
  out.center_x_m = patch.center_x_m;
  out.center_y_m = patch.center_y_m;
  out.radius_m = patch.radius_m;
  return out;
}

}  // namespace slipd
