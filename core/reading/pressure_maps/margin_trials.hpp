// Trial margins of one frame, and what recorded pressure maps say of each: how well it explains the shear,
// and with which friction. Shared by the methods with maps (docs/methods.md §25). Estimate thread; nothing
// allocates.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "core/patch/patch.hpp"
#include "core/reading/method/friction_prior.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

// How one trial margin explains the shear.
struct MarginTrial {
  double gamma = 0;         // 0 … 1
  double friction = 0;      // most likely with the prior, > 0; 0: nothing is known
  double nats = 0;          // against this friction
  double misfit = 0;        // half the squared residual in units of noise; where trials differ in their
                            // noise, with half its logarithm; nats
  double residual_pa2 = 0;  // sum of squares, Pa^2
  double noise_pa2 = 0;     // variance of one value's residual, Pa^2
  double map_share = 0;     // the maps' part of it, 0 … 1
};

// What of a frame's shear a pull explains, sums of squares, Pa^2.
struct ShearSquares {
  double excess_pa2 = 0;     // neither the pull nor noise explains it
  double noise_pa2 = 0;      // standard deviation of the first
  double explained_pa2 = 0;  // by the pull
  // The share of the shear, 0 … 1, that is not explained, where that is clearly more than noise; else 0.
  double unexplained_share() const noexcept;
};

class MarginTrials {
 public:
  // Trial margins, evenly in 0 … 1.
  static constexpr std::size_t kStepsOfProfile = 5;  // odd: one lies in the middle of a profile's step
  static constexpr std::size_t kSteps = kStepsOfProfile * MarginProfile::kSteps;
  static constexpr double gamma_of(std::size_t step) noexcept {
    return (static_cast<double>(step) + 0.5) / kSteps;
  }

  explicit MarginTrials(const FrictionPrior& prior) noexcept : prior_(prior) {}

  // step: below kSteps.
  MarginTrial& operator[](std::size_t step) noexcept { return trials_[step]; }
  auto begin() noexcept { return trials_.begin(); }
  auto end() noexcept { return trials_.end(); }

  // Fills friction and nats. measured: friction by the frame alone. square_pa2: of what a friction of 1 would
  // be sensed as. The trial has its noise.
  void weigh_friction(double measured, double square_pa2, MarginTrial& trial) const noexcept;

  // The most likely one, with the prior; the one that leaves least, whatever the prior says.
  std::optional<std::size_t> best() const noexcept;
  std::optional<std::size_t> closest() const noexcept;

  // Margin, friction and their deviations: means over the likelihood of all trials, which need not be a
  // parabola. Not in the model if nothing is known.
  void weigh(Reading& out) const noexcept;
  // The likelihood itself, without the prior.
  void give_profile(Reading& out) const noexcept;

 private:
  const FrictionPrior prior_;
  std::array<MarginTrial, kSteps> trials_;
};

// What follows from a reading in the model, by `best` of its trials, whose maps leave such a share of the
// shear unexplained: the deviations that the maps add, and where the contact is.
void conclude(const ContactPatch& patch, const MarginTrial& best, double unexplained_share,
              Reading& out) noexcept;

}  // namespace slipd
