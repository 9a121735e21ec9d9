#include "core/estimate/friction_grid.hpp"

#include <cmath>

namespace slipd {
namespace {

constexpr double kLeastSigma = 0.02;  // of friction, relative: contacts are not as even as their model
constexpr double kRestBelow = 12, kRestAbove = 20;  // a friction below, above the likeliest keeps exp(-this)
constexpr double kMostUnexpected = 40;  // the least weight that the scene leaves a friction, as a logarithm
constexpr double kSharpest = 8;         // by which its neighbours fall behind the likeliest
constexpr double kSharp = 0.1;          // relative: a friction known so well needs no sum over all

double square(double x) noexcept {
  return x * x;
}

}  // namespace

FrictionGrid::FrictionGrid(Range expected, double spread, std::size_t count)
    : count_(count), step_(std::log(kHigh / kLow) / static_cast<double>(count - 1)) {
  for (std::size_t j = 0; j < count_; ++j) {
    friction_[j] = kLow * std::exp(step_ * static_cast<double>(j));
    const double beyond =
        std::max({0.0, std::log(friction_[j] / expected.high), std::log(expected.low / friction_[j])});
    prior_[j] = std::max(-0.5 * square(beyond / spread), -kMostUnexpected);
  }
  reset();
}

void FrictionGrid::fade(double keep) noexcept {
  for (std::size_t j = 0; j < count_; ++j) weight_[j] = prior_[j] + keep * (weight_[j] - prior_[j]);
}

std::size_t FrictionGrid::likeliest() const noexcept {
  const auto end = weight_.begin() + static_cast<std::ptrdiff_t>(count_);
  return static_cast<std::size_t>(std::max_element(weight_.begin(), end) - weight_.begin());
}

void FrictionGrid::normalise() noexcept {
  const std::size_t top = likeliest();
  const double most = weight_[top];
  const double beside =
      std::max(top > 0 ? weight_[top - 1] : -1e300, top + 1 < count_ ? weight_[top + 1] : -1e300);
  const double soften = std::min(1.0, kSharpest / (most - beside + 1e-9));
  for (std::size_t j = 0; j < count_; ++j)
    weight_[j] = std::max(soften * (weight_[j] - most), prior_[j] - (j < top ? kRestBelow : kRestAbove));
}

FrictionGrid::Value FrictionGrid::friction() const noexcept {
  const std::size_t top = likeliest();
  double sum = 0, mean = 0, squares = 0, near = 0;
  for (std::size_t j = 0; j < count_; ++j) {
    const double w = std::exp(weight_[j]);
    sum += w;
    mean += w * friction_[j];
    squares += w * square(friction_[j]);
    if (j + 2 >= top && j <= top + 2) near += w;
  }
  mean /= sum;
  Value value{mean, std::sqrt(std::max(0.0, squares / sum - mean * mean))};
  if (top > 0 && top + 1 < count_ && near > 0.97 * sum) {  // as sharp as the grid: a parabola about the top
    const double below = weight_[top - 1], above = weight_[top + 1], curve = -below - above;
    const double apart = step_;
    if (curve > 0.5) {
      value.mean = friction_[top] * std::exp(0.5 * apart * (above - below) / curve);
      value.sigma = value.mean * apart / std::sqrt(curve);
    }
  }
  value.sigma = std::hypot(value.sigma, kLeastSigma * value.mean);
  return value;
}

FrictionGrid::Value FrictionGrid::margin(double load, double load_sigma) const noexcept {
  const Value mu = friction();
  if (mu.sigma < kSharp * mu.mean) {
    const double mobilised = load / mu.mean;
    return {std::clamp(1 - mobilised, 0.0, 1.0), std::hypot(mobilised * mu.sigma, load_sigma) / mu.mean};
  }
  double sum = 0, mean = 0, squares = 0;
  for (std::size_t j = 0; j < count_; ++j) {
    const double w = std::exp(weight_[j]), gamma = std::clamp(1 - load / friction_[j], 0.0, 1.0);
    sum += w;
    mean += w * gamma;
    squares += w * gamma * gamma;
  }
  mean /= sum;
  const double mobilised = 1 - mean, grid = step_ * mobilised;
  return {mean, std::sqrt(std::max(0.0, squares / sum - mean * mean) + grid * grid / 12 +
                          square(load_sigma * mobilised / std::max(load, 1e-9)))};
}

}  // namespace slipd
