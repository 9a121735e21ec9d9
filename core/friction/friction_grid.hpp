// Weights on an even grid of log mu: what is believed of friction, and what that says of mu, 1/mu and the
// margin (docs/methods.md §28). Estimate thread; fixed memory, nothing allocates.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "core/contact/scene.hpp"
#include "core/numeric/posterior_sums.hpp"
#include "core/reading/method/friction_prior.hpp"

namespace slipd {

// Checked with `slipd-lab histories --grasps 400` and `slipd-lab tradeoff --layouts 4,wrench`.
struct FrictionGridOptions {
  // The grid's ends, mu; the lower one 0.01 … 0.1. Too narrow: frictions outside come out as the end. Too
  // wide: the step grows, and with it what no frame can distinguish.
  double min_friction = 0.04;
  double max_friction = kMostFriction;
};

class FrictionGrid {
 public:
  static constexpr std::size_t kMost = 224;

  // count: points of the grid, 2 … kMost.
  FrictionGrid(const FrictionPrior& prior, std::size_t count, const FrictionGridOptions& options = {});

  // Back to the prior.
  void reset() noexcept;
  // New weights, >= 0, of which only the ratios count. Without any to speak of: back to the prior.
  void assign(std::span<const double> weights) noexcept;

  std::size_t count() const noexcept { return count_; }
  double friction(std::size_t j) const noexcept { return friction_[j]; }
  std::span<const double> frictions() const noexcept { return std::span(friction_).first(count_); }
  // Of point j; all of them together are 1.
  double weight(std::size_t j) const noexcept { return weight_[j]; }
  double prior(std::size_t j) const noexcept { return prior_[j]; }
  std::size_t likeliest() const noexcept { return summary().likeliest; }

  // mu, with its floor of sigma.
  MeanSigma friction() const noexcept;

  // mu that friction exceeds with 95 % confidence. common: standard deviation, relative, of errors that all
  // frames share, >= 0.
  double least_friction(double common) const noexcept;

  // 1/mu, and its standard deviation.
  MeanSigma inverse_friction() const noexcept;

  // Gamma = 1 - load/mu, within 0 … 1, for load = |Q|/P >= 0 with its sigma.
  MeanSigma margin(double load, double load_sigma) const noexcept;

  // Between two points, in log mu.
  double step() const noexcept { return step_; }

 private:
  // Of the weights: the point with the most, and quantiles, mu.
  struct Summary {
    std::size_t likeliest = 0;
    double least = 0, low = 0, middle = 0, high = 0;
  };
  const Summary& summary() const noexcept {
    if (!summary_) summary_ = summarise();
    return *summary_;
  }
  Summary summarise() const noexcept;

  using PerFriction = std::array<double, kMost>;

  const FrictionGridOptions options_;
  const std::size_t count_;
  const double step_;
  PerFriction friction_{}, inverse_{}, prior_{}, weight_{};
  mutable std::optional<Summary> summary_;  // none: the weights are new
};

}  // namespace slipd
