#include "lab/error_statistics.hpp"

#include <algorithm>
#include <cmath>

namespace lab {

void ErrorStatistics::add(const slipd::Estimate& estimate, double truth) {
  frames_ += 1;
  states_[static_cast<std::size_t>(estimate.state)] += 1;
  if (estimate.gamma_low) {
    const double above = *estimate.gamma_low - truth;
    low_ += 1;
    low_above_ += above > 0 ? 1 : 0;
    low_worst_ = std::max(low_worst_, above);
    low_shortfall_ += std::max(0.0, -above);
  }
  if (!estimate.gamma) return;
  const double off = *estimate.gamma - truth, sigma = estimate.sigma.value_or(0);
  answered_ += 1;
  error_ += std::fabs(off);
  worst_ = std::max(worst_, std::fabs(off));
  const auto class_of = [](double gamma) { return slipd::slip_class(std::clamp(gamma, 0.0, 1.0)); };
  class_correct_ += class_of(*estimate.gamma) == class_of(truth) ? 1 : 0;
  overestimated_ += off > kGrossError ? 1 : 0;
  underestimated_ += off < -kGrossError ? 1 : 0;
  for (std::size_t i = 0; i < within_.size(); ++i)
    within_[i] += std::fabs(off) <= static_cast<double>(i + 1) * sigma ? 1 : 0;
}

void ErrorStatistics::add(const ErrorStatistics& other) {
  frames_ += other.frames_;
  answered_ += other.answered_;
  error_ += other.error_;
  worst_ = std::max(worst_, other.worst_);
  class_correct_ += other.class_correct_;
  overestimated_ += other.overestimated_;
  underestimated_ += other.underestimated_;
  low_ += other.low_;
  low_above_ += other.low_above_;
  low_worst_ = std::max(low_worst_, other.low_worst_);
  low_shortfall_ += other.low_shortfall_;
  for (std::size_t i = 0; i < within_.size(); ++i) within_[i] += other.within_[i];
  for (std::size_t i = 0; i < states_.size(); ++i) states_[i] += other.states_[i];
}

}  // namespace lab
