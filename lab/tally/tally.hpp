// Estimates counted against the truth: the one tally of every command.
#pragma once

#include <array>
#include <cstddef>

#include "core/estimate/estimate.hpp"
#include "core/frame/frame.hpp"

namespace lab {

// The error of the margin that counts as gross unless a command says otherwise: an overestimate lets objects
// slip, an underestimate crushes them.
inline constexpr double kGrossError = 0.2;
// How much above the truth a gamma_low is clearly above it.
inline constexpr double kClearlyAbove = 0.1;

// Frames with an estimate that has a margin are answered. Shares and means of no frames are NaN.
class Tally {
 public:
  static constexpr std::size_t kStates = 8;  // of slipd::State

  Tally() noexcept = default;
  explicit Tally(double gross_error) noexcept : gross_error_(gross_error) {}

  // The estimate of a frame of a contact with this truth.
  void add(const slipd::Estimate& estimate, const slipd::Truth& truth);
  // What another tally of the same gross error has counted.
  void add(const Tally& other);

  double frames() const noexcept { return frames_; }
  double answers() const noexcept { return answers_; }
  double answered() const noexcept { return share(answers_, frames_); }
  double in_state(slipd::State state) const noexcept {
    return share(states_[static_cast<std::size_t>(state)], frames_);
  }

  // Of the answers: mean and largest error, and the mean of margin less truth.
  double mean_error() const noexcept { return share(error_, answers_); }
  double worst() const noexcept { return worst_; }
  double bias() const noexcept { return share(above_, answers_); }
  // The largest margin less truth; 0 where none is above it.
  double most_above() const noexcept { return most_above_; }
  double class_correct() const noexcept { return share(class_correct_, answers_); }
  // Answers that are above the truth by more than the gross error: their number, and their share; the share
  // below.
  double overestimates() const noexcept { return overestimates_; }
  double overestimated() const noexcept { return share(overestimates_, answers_); }
  double underestimated() const noexcept { return share(underestimates_, answers_); }
  // The share whose error is within so many (1 to 3) of the estimate's sigma; the number beyond them.
  double within(std::size_t sigmas) const noexcept { return share(within_.at(sigmas - 1), answers_); }
  double beyond(std::size_t sigmas) const noexcept { return answers_ - within_.at(sigmas - 1); }
  // 1 where no sigma is smaller.
  double least_sigma() const noexcept { return least_sigma_; }

  // Of gamma_low, of frames that have one: the shares above the truth and clearly above it, how much it is
  // above it at most, and its mean distance below the truth (0 counts as a bound).
  double low_above() const noexcept { return share(low_above_, low_); }
  double low_clearly_above() const noexcept { return share(low_clearly_above_, low_); }
  // Their numbers.
  double lows() const noexcept { return low_; }
  double lows_above() const noexcept { return low_above_; }
  double lows_clearly_above() const noexcept { return low_clearly_above_; }
  double low_worst() const noexcept { return low_worst_; }
  double low_shortfall() const noexcept { return share(low_shortfall_, low_); }

  // Of answers with a friction: its mean relative error, and the share off by more than a tenth.
  double friction_error() const noexcept { return share(friction_error_, frictions_); }
  double friction_wrong() const noexcept { return share(friction_wrong_, frictions_); }

 private:
  static double share(double of, double all) noexcept { return all > 0 ? of / all : slipd::kUnknown; }
  void add_bound(double gamma_low, double truth);
  void add_margin(double gamma, double sigma, double truth);
  void add_friction(double friction, double truth);

  double gross_error_ = kGrossError;
  double frames_ = 0, answers_ = 0, error_ = 0, worst_ = 0, above_ = 0, most_above_ = 0, class_correct_ = 0,
         overestimates_ = 0, underestimates_ = 0, least_sigma_ = 1;
  double low_ = 0, low_above_ = 0, low_clearly_above_ = 0, low_worst_ = 0, low_shortfall_ = 0;
  double frictions_ = 0, friction_error_ = 0, friction_wrong_ = 0;
  std::array<double, 3> within_{};
  std::array<double, kStates> states_{};
};

}  // namespace lab
