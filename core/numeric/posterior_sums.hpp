// Mean and standard deviation of a posterior that is given as weights on a grid (docs/methods.md §28).
#pragma once

#include <algorithm>

namespace slipd {

struct MeanSigma {
  double mean = 0;   // in the unit of the quantity
  double sigma = 0;  // standard deviation, same unit, >= 0
};

// Weights need not sum to 1. No allocation; mean() and variance() ask for a weight above 0.
class PosteriorSums {
 public:
  void add(double weight, double value) noexcept {
    const double weighed = weight * value;
    weight_ += weight;
    sum_ += weighed;
    squares_ += weighed * value;
  }
  double weight() const noexcept { return weight_; }
  double mean() const noexcept { return sum_ / weight_; }
  // >= 0, whatever rounding does.
  double variance() const noexcept { return std::max(0.0, squares_ / weight_ - mean() * mean()); }

 private:
  double weight_ = 0, sum_ = 0, squares_ = 0;
};

// Variance of a quantity that is only known to lie within a step of its grid: uniform, step^2/12.
constexpr double variance_of_step(double step) noexcept {
  return step * step / 12;
}

}  // namespace slipd
