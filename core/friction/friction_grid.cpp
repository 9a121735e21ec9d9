#include "core/friction/friction_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
FrictionGrid::FrictionGrid(const FrictionPrior& prior, std::size_t count, const FrictionGridOptions& options)
    : options_(options),
      count_(count),
      step_(std::log(options.max_friction / options.min_friction) / static_cast<double>(count - 1)) {
  // In nats: a friction far outside of what the scene expects can still be learnt.
  constexpr double kMostAgainst = 40;
  double sum = 0;
  for (std::size_t j = 0; j < count_; ++j) {
    friction_[j] = options.min_friction * std::exp(step_ * static_cast<double>(j));
    prior_[j] = std::exp(-std::min(prior.nats_against(friction_[j]), kMostAgainst));
    sum += prior_[j];
  }
  for (std::size_t j = 0; j < count_; ++j) {
    prior_[j] /= sum;
    inverse_[j] = 1 / friction_[j];
  }
  reset();
}

void FrictionGrid::reset() noexcept {
  weight_ = prior_;
  summary_.reset();
}

void FrictionGrid::assign(std::span<const double> weights) noexcept {
  const auto these = weights.first(count_);
  const double sum = std::accumulate(these.begin(), these.end(), 0.0);
  if (!(sum >= std::numeric_limits<double>::min())) {  // else its inverse is not finite
    reset();
    return;
  }
  std::transform(these.begin(), these.end(), weight_.begin(),
                 [per = 1 / sum](double weight) { return weight * per; });
  summary_.reset();
}

// Median, and half of what lies between the quantiles of one standard deviation: a change of friction that
// may have been, with a small weight far away, does not widen what is known of the present one; only the
// quantile of 5 % counts it. What lies between two points of the grid is not distinguished.
FrictionGrid::Summary FrictionGrid::summarise() const noexcept {
  constexpr double kLeast = 0.05;
  constexpr double kLow = 0.1587, kHigh = 0.8413;  // of a Gaussian, one standard deviation on either side
  const auto end = weight_.begin() + static_cast<std::ptrdiff_t>(count_);
  PerFriction up_to;  // the weights up to each point, with it; the first count_
  std::partial_sum(weight_.begin(), end, up_to.begin());
  const auto place = [&](double share) {
    const auto last = up_to.begin() + static_cast<std::ptrdiff_t>(count_ - 1);
    const auto j = static_cast<std::size_t>(std::lower_bound(up_to.begin(), last, share) - up_to.begin());
    const double below = j > 0 ? up_to[j - 1] : 0;
    return friction_[j] * std::exp(step_ * ((share - below) / weight_[j] - 0.5));
  };
  return {.likeliest = static_cast<std::size_t>(std::max_element(weight_.begin(), end) - weight_.begin()),
          .least = place(kLeast),
          .low = place(kLow),
          .middle = place(0.5),
          .high = place(kHigh)};
}

MeanSigma FrictionGrid::friction() const noexcept {
  const Summary& mu = summary();
  return {mu.middle, norm(0.5 * (mu.high - mu.low), kUnevenShare * mu.middle)};
}

double FrictionGrid::least_friction(double common) const noexcept {
  const double middle = summary().middle, below = kOneSided95 * norm(kUnevenShare, common) * middle;
  return std::max(0.0, middle - norm(middle - summary().least, below));
}

MeanSigma FrictionGrid::inverse_friction() const noexcept {
  const Summary& mu = summary();
  return {1 / mu.middle, norm(0.5 * (1 / mu.low - 1 / mu.high), kUnevenShare / mu.middle)};
}

// Sigma counts all that friction may be.
MeanSigma FrictionGrid::margin(double load, double load_sigma) const noexcept {
  load_sigma = norm(load_sigma, kExactShare);
  const double middle = summary().middle;
  const double margin = std::clamp(1 - load / middle, 0.0, 1.0);
  double variance = 0;
#pragma omp simd reduction(+ : variance)
  for (std::size_t j = 0; j < count_; ++j) {
    const double by = std::min(1.0, std::max(0.0, 1 - load * inverse_[j])) - margin;
    variance += weight_[j] * by * by;
  }
  const double floor = norm(kUnevenShare, std::sqrt(variance_of_step(step_)));
  return {margin, std::sqrt(variance + std::pow(floor * (1 - margin), 2) + std::pow(load_sigma / middle, 2))};
}

}  // namespace slipd
