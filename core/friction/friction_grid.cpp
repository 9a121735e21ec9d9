#include "core/friction/friction_grid.hpp"

#include <cmath>
#include <limits>

namespace slipd {
namespace {

double square(double x) noexcept {
  return x * x;
}

}  // namespace

FrictionGrid::FrictionGrid(const FrictionPrior& prior, std::size_t count, const FrictionGridOptions& options)
    : options_(options),
      count_(count),
      step_(std::log(options.max_friction / options.min_friction) / static_cast<double>(count - 1)) {
  for (std::size_t j = 0; j < count_; ++j) {
    friction_[j] = options.min_friction * std::exp(step_ * static_cast<double>(j));
    log_prior_[j] = -std::min(prior.nats_against(friction_[j]), options.max_prior_nats);
  }
  reset();
}

void FrictionGrid::fade(double keep) noexcept {
  for (std::size_t j = 0; j < count_; ++j)
    log_weight_[j] = log_prior_[j] + keep * (log_weight_[j] - log_prior_[j]);
}

void FrictionGrid::open_below(double nats) noexcept {
  const std::size_t top = likeliest();
  for (std::size_t j = 0; j < top; ++j) log_weight_[j] = std::max(log_weight_[j], log_weight_[top] - nats);
}

std::size_t FrictionGrid::likeliest() const noexcept {
  const auto end = log_weight_.begin() + static_cast<std::ptrdiff_t>(count_);
  return static_cast<std::size_t>(std::max_element(log_weight_.begin(), end) - log_weight_.begin());
}

void FrictionGrid::normalise() noexcept {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  constexpr double kNoLead = 1e-9;  // nats: keeps the quotient finite where two points are level
  const std::size_t top = likeliest();
  const double most = log_weight_[top];
  const double beside =
      std::max(top > 0 ? log_weight_[top - 1] : kNone, top + 1 < count_ ? log_weight_[top + 1] : kNone);
  const double soften = std::min(1.0, options_.max_lead_nats / (most - beside + kNoLead));
  for (std::size_t j = 0; j < count_; ++j) {
    const double floor = log_prior_[j] - (j < top ? options_.floor_below_nats : options_.floor_above_nats);
    log_weight_[j] = std::max(soften * (log_weight_[j] - most), floor);
  }
}

MeanSigma FrictionGrid::friction() const noexcept {
  const std::size_t top = likeliest();
  PosteriorSums sums;
  double near_top = 0;
  for (std::size_t j = 0; j < count_; ++j) {
    const double w = std::exp(log_weight_[j]);
    sums.add(w, friction_[j]);
    if (j + 2 >= top && j <= top + 2) near_top += w;
  }
  MeanSigma mu{sums.mean(), std::sqrt(sums.variance())};
  if (top > 0 && top + 1 < count_ && near_top > options_.peak_share * sums.weight()) {
    // The peak is as sharp as the grid: a parabola through its three points, of which the top's is 0.
    const double below = log_weight_[top - 1], above = log_weight_[top + 1], curvature = -below - above;
    if (curvature > options_.min_curvature_nats) {
      mu.mean = friction_[top] * std::exp(0.5 * step_ * (above - below) / curvature);
      mu.sigma = mu.mean * step_ / std::sqrt(curvature);
    }
  }
  mu.sigma = std::hypot(mu.sigma, options_.sigma_floor * mu.mean);
  return mu;
}

MeanSigma FrictionGrid::inverse_friction() const noexcept {
  const MeanSigma mu = friction();
  if (mu.sigma < options_.sharp_sigma * mu.mean) return {1 / mu.mean, mu.sigma / (mu.mean * mu.mean)};
  PosteriorSums sums;
  for (std::size_t j = 0; j < count_; ++j) sums.add(std::exp(log_weight_[j]), 1 / friction_[j]);
  return {sums.mean(), std::sqrt(sums.variance())};
}

MeanSigma FrictionGrid::margin(double load, double load_sigma) const noexcept {
  const MeanSigma mu = friction();
  load_sigma = std::hypot(load_sigma, options_.load_floor);
  if (mu.sigma < options_.sharp_sigma * mu.mean) {
    const double utilisation = load / mu.mean;
    return {std::clamp(1 - utilisation, 0.0, 1.0), std::hypot(utilisation * mu.sigma, load_sigma) / mu.mean};
  }
  PosteriorSums sums;
  for (std::size_t j = 0; j < count_; ++j)
    sums.add(std::exp(log_weight_[j]), std::clamp(1 - load / friction_[j], 0.0, 1.0));
  const double utilisation = 1 - sums.mean();
  const double per_load = load > options_.load_floor ? utilisation / load : 1 / mu.mean;
  return {sums.mean(),
          std::sqrt(sums.variance() + variance_of_step(step_ * utilisation) + square(load_sigma * per_load))};
}

}  // namespace slipd
