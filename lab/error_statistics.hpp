// Statistics of estimates against the truth.
#pragma once

#include <array>
#include <cstddef>

#include "core/estimate/estimate.hpp"

namespace lab {

// The error of the margin that counts as gross: an overestimate lets objects slip, an underestimate crushes
// them.
inline constexpr double kGrossError = 0.2;

class ErrorStatistics {
 public:
  static constexpr std::size_t kStates = 8;  // of slipd::State

  // The estimate of a frame of a contact with the true margin `truth`.
  void add(const slipd::Estimate& estimate, double truth);
  void add(const ErrorStatistics& other);

  double frames() const noexcept { return frames_; }
  double answered() const noexcept { return share(answered_, frames_); }  // in state ok, of all frames
  // The following count frames in state ok only; NaN where there is none.
  double mean_error() const noexcept { return share(error_, answered_); }
  double worst() const noexcept { return worst_; }
  double class_correct() const noexcept { return share(class_correct_, answered_); }
  // The share whose margin is more than kGrossError above, or below, the truth.
  double overestimated() const noexcept { return share(overestimated_, answered_); }
  double underestimated() const noexcept { return share(underestimated_, answered_); }
  // The share whose error is within so many (1 to 3) of the estimate's sigma.
  double within(std::size_t sigmas) const noexcept { return share(within_.at(sigmas - 1), answered_); }
  // Of gamma_low, of frames that have one: the share above the truth, how much it is above it at most, and
  // its mean distance below the truth (0 counts as a bound).
  double low_above() const noexcept { return share(low_above_, low_); }
  double low_worst() const noexcept { return low_worst_; }
  double low_shortfall() const noexcept { return share(low_shortfall_, low_); }
  double in_state(slipd::State state) const noexcept {
    return share(states_[static_cast<std::size_t>(state)], frames_);
  }

 private:
  static double share(double of, double all) noexcept { return all > 0 ? of / all : slipd::kUnknown; }

  double frames_ = 0, answered_ = 0, error_ = 0, worst_ = 0, class_correct_ = 0, overestimated_ = 0,
         underestimated_ = 0;
  double low_ = 0, low_above_ = 0, low_worst_ = 0, low_shortfall_ = 0;
  std::array<double, 3> within_{};
  std::array<double, kStates> states_{};
};

}  // namespace lab
