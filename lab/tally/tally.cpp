#include "lab/tally/tally.hpp"

#include <algorithm>
#include <cmath>

namespace lab {
namespace {

int class_of(double gamma) {
  return slipd::slip_class(std::clamp(gamma, 0.0, 1.0));
}

}  // namespace

void Tally::add_bound(double gamma_low, double truth) {
  const double above = gamma_low - truth;
  low_ += 1;
  low_above_ += above > 0 ? 1 : 0;
  low_clearly_above_ += above > kClearlyAbove ? 1 : 0;
  low_worst_ = std::max(low_worst_, above);
  low_shortfall_ += std::max(0.0, -above);
}

void Tally::add_margin(double gamma, double sigma, double truth) {
  const double above = gamma - truth;
  answers_ += 1;
  error_ += std::fabs(above);
  worst_ = std::max(worst_, std::fabs(above));
  above_ += above;
  most_above_ = std::max(most_above_, above);
  class_correct_ += class_of(gamma) == class_of(truth) ? 1 : 0;
  overestimates_ += above > gross_error_ ? 1 : 0;
  underestimates_ += above < -gross_error_ ? 1 : 0;
  least_sigma_ = std::min(least_sigma_, sigma);
  for (std::size_t i = 0; i < within_.size(); ++i)
    within_[i] += std::fabs(above) <= static_cast<double>(i + 1) * sigma ? 1 : 0;
}

void Tally::add_friction(double friction, double truth) {
  constexpr double kWrong = 0.1;
  const double off = std::fabs(friction / truth - 1);
  frictions_ += 1;
  friction_error_ += off;
  friction_wrong_ += off > kWrong ? 1 : 0;
}

void Tally::add(const slipd::Estimate& estimate, const slipd::Truth& truth) {
  frames_ += 1;
  states_[static_cast<std::size_t>(estimate.state)] += 1;
  if (estimate.gamma_low) add_bound(*estimate.gamma_low, truth.gamma);
  if (!estimate.gamma) return;
  add_margin(*estimate.gamma, estimate.sigma.value_or(0), truth.gamma);
  if (estimate.friction) add_friction(*estimate.friction, truth.friction);
}

void Tally::add(const Tally& other) {
  for (double Tally::*sum :
       {&Tally::frames_, &Tally::answers_, &Tally::error_, &Tally::above_, &Tally::class_correct_,
        &Tally::overestimates_, &Tally::underestimates_, &Tally::low_, &Tally::low_above_,
        &Tally::low_clearly_above_, &Tally::low_shortfall_, &Tally::frictions_, &Tally::friction_error_,
        &Tally::friction_wrong_})
    this->*sum += other.*sum;
  for (double Tally::*most : {&Tally::worst_, &Tally::most_above_, &Tally::low_worst_})
    this->*most = std::max(this->*most, other.*most);
  least_sigma_ = std::min(least_sigma_, other.least_sigma_);
  for (std::size_t i = 0; i < within_.size(); ++i) within_[i] += other.within_[i];
  for (std::size_t i = 0; i < states_.size(); ++i) states_[i] += other.states_[i];
}

}  // namespace lab
