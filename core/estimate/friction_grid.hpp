// Every friction that may be, and what speaks for it: logarithms of weights on an even grid of log mu. A
// friction that lost its weight keeps a rest, so that it can be believed again. Estimate thread; fixed
// memory.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "core/contact/scene.hpp"

namespace slipd {

class FrictionGrid {
 public:
  static constexpr std::size_t kMost = 224;

  // The range expected ends softly, over about `spread` of log mu. count: 2 … kMost.
  FrictionGrid(Range expected, double spread, std::size_t count);

  void reset() noexcept { weight_ = prior_; }  // what the scene expects
  // 1 leaves all as it is, 0 is reset.
  void fade(double keep) noexcept;
  // `nats` >= 0 of evidence against one; no more than a frame may say counts.
  void take(std::size_t j, double nats) noexcept { weight_[j] -= std::min(nats, kMostOfFrame); }
  // After each frame: the likeliest gets 0, none falls below its rest, and none stands out so sharply that a
  // later frame could not move it.
  void normalise() noexcept;

  std::size_t count() const noexcept { return count_; }
  double friction(std::size_t j) const noexcept { return friction_[j]; }
  std::span<const double> frictions() const noexcept { return std::span(friction_).first(count_); }
  bool refuted(std::size_t j) const noexcept { return weight_[j] < -kRefuted; }
  std::size_t likeliest() const noexcept;

  struct Value {
    double mean = 0, sigma = 0;
  };
  Value friction() const noexcept;
  Value margin(double load, double load_sigma) const noexcept;  // of 1 - load/mu, load = |Q|/P

  double step() const noexcept { return step_; }  // of log mu

 private:
  static constexpr double kLow = 0.04, kHigh = 2.2;
  static constexpr double kMostOfFrame = 20;  // no single frame says more
  static constexpr double kRefuted = 8;       // behind the likeliest
  using PerFriction = std::array<double, kMost>;

  std::size_t count_;
  double step_;
  PerFriction friction_{}, prior_{}, weight_{};
};

}  // namespace slipd
