// What estimates were worth against the truth: counted, added up, and turned into shares.
#pragma once

#include <array>
#include <cstddef>

#include "core/estimate/estimate.hpp"

namespace sliplab {

// How far off an answer is a claim: a margin told that much above the truth drops objects, below it squeezes
// them.
inline constexpr double kClaim = 0.2;

class Tally {
 public:
  static constexpr std::size_t kStates = 8;  // of slipd::State

  // truth: the margin; a frame of a contact.
  void add(const slipd::Estimate& estimate, double truth);
  void add(const Tally& other);

  double frames() const noexcept { return frames_; }
  double answered() const noexcept { return share(answered_, frames_); }  // in state ok, of all frames
  // Of the frames answered; NaN where none was.
  double mean_error() const noexcept { return share(error_, answered_); }
  double worst() const noexcept { return worst_; }
  double right() const noexcept { return share(right_, answered_); }  // the class
  double over() const noexcept { return share(over_, answered_); }    // safer by kClaim than it is
  double under() const noexcept { return share(under_, answered_); }  // less safe by kClaim
  // Within so many (1 to 3) of the deviations that they came with.
  double within(std::size_t sigmas) const noexcept { return share(within_.at(sigmas - 1), answered_); }
  double in_state(slipd::State state) const noexcept {
    return share(states_[static_cast<std::size_t>(state)], frames_);
  }

 private:
  static double share(double of, double all) noexcept { return all > 0 ? of / all : slipd::kUnknown; }

  double frames_ = 0, answered_ = 0, error_ = 0, worst_ = 0, right_ = 0, over_ = 0, under_ = 0;
  std::array<double, 3> within_{};
  std::array<double, kStates> states_{};
};

}  // namespace sliplab
