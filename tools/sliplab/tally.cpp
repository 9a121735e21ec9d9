#include "tools/sliplab/tally.hpp"

#include <algorithm>
#include <cmath>

namespace sliplab {

void Tally::add(const slipd::Estimate& estimate, double truth) {
  frames_ += 1;
  states_[static_cast<std::size_t>(estimate.state)] += 1;
  if (!estimate.gamma) return;
  const double off = *estimate.gamma - truth, sigma = estimate.sigma.value_or(0);
  answered_ += 1;
  error_ += std::fabs(off);
  worst_ = std::max(worst_, std::fabs(off));
  const auto class_of = [](double gamma) { return slipd::slip_class(std::clamp(gamma, 0.0, 1.0)); };
  right_ += class_of(*estimate.gamma) == class_of(truth) ? 1 : 0;
  over_ += off > kClaim ? 1 : 0;
  under_ += off < -kClaim ? 1 : 0;
  for (std::size_t i = 0; i < within_.size(); ++i)
    within_[i] += std::fabs(off) <= static_cast<double>(i + 1) * sigma ? 1 : 0;
}

void Tally::add(const Tally& other) {
  frames_ += other.frames_;
  answered_ += other.answered_;
  error_ += other.error_;
  worst_ = std::max(worst_, other.worst_);
  right_ += other.right_;
  over_ += other.over_;
  under_ += other.under_;
  for (std::size_t i = 0; i < within_.size(); ++i) within_[i] += other.within_[i];
  for (std::size_t i = 0; i < states_.size(); ++i) states_[i] += other.states_[i];
}

}  // namespace sliplab
