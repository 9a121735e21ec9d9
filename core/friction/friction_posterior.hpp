// The one posterior of friction over a grasp (docs/methods.md §28). Friction stays as it was, or it has just
// changed to another that the scene expects: each frame is weighed under both (change-point detection, Adams
// and MacKay 2007). Frames of one contact share a part of their error: each friction follows it, so that a
// hundred frames alike count as little more than one, and a step from one frame to the next counts in full.
// Single wild frames have the tail of Student's t. Estimate thread; fixed memory, nothing allocates.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/friction/friction_grid.hpp"

namespace slipd {

// What frames show friction by: each has a common error of its own.
enum class Evidence : std::uint8_t { margin, slip_moment, second_legendre, torque, slide };

// Checked with `slipd-lab histories --grasps 400` and `slipd-lab tradeoff --layouts 4,wrench`.
struct FrictionPosteriorOptions {
  FrictionGridOptions grid;
  // How often friction falls, and rises, while an object is held; 1/s, 0.01 … 10 and 0 … 1. It then is any
  // that the scene expects. Too small: a change is learnt late. Too large: noise passes for one, and what was
  // learnt is forgotten sooner. Falls come first: a rise is no danger, and shows only once the load needs it.
  double falls_per_s = 1;
  double rises_per_s = 0.1;
  // Share by which forces have to move, of the normal force and of the friction limit, for a frame's error to
  // be another one to 1/e; 0.05 … 5. Too small: sigma is less than the error after a hold. Too large: learns
  // slowly.
  double decorrelating_share = 3;
  // The least noise of a frame, of the error that it shares with others; 0.1 … 3: no error is quite the
  // same in two frames. Too small: what changes in it passes for a change of friction. Too large: a change of
  // friction is learnt late.
  double least_noise_share = 1;
};

class FrictionPosterior {
 public:
  // count: points of the grid, 2 … FrictionGrid::kMost.
  FrictionPosterior(const FrictionPrior& prior, std::size_t count,
                    const FrictionPosteriorOptions& options = {});

  // Back to the prior; within a frame, too.
  void reset() noexcept;

  // --- one frame: begin, any of the three in between, conclude

  // seconds: since the frame before, >= 0.
  void begin(double seconds) noexcept;
  // Friction may be another one, with this probability, 0 … 1, and more than it was `rises` times as likely
  // as less.
  void may_have_changed(double probability, double rises = 1) noexcept;
  // With this probability, 0 … 1, friction has just fallen to |Q|/P, `load`, with its sigma: the object
  // slides. As much less likely as the scene expects it less.
  void may_have_fallen_to(const MeanSigma& load, double probability) noexcept;
  // Coulomb: friction is at least the |Q|/P that it holds, with its sigma > 0. What held before is no
  // evidence again: of many frames alike the noisiest would decide.
  void bound_below(const MeanSigma& held) noexcept;
  // residual: of each friction, what the frame shows less what that friction expects. common: the standard
  // deviation that frames have in common; noise: that of this frame alone; > 0 together.
  void weigh(Evidence by, std::span<const double> residual, double common, double noise) noexcept;
  // The same of a frame that is weighed by other evidence already: only the common error is followed.
  void follow(Evidence by, std::span<const double> residual, double common, double noise) noexcept;
  // True if some friction is likelier to have become so in this frame than to have been so before: see
  // has_changed().
  bool conclude() noexcept;
  bool has_changed(std::size_t j) const noexcept { return has_changed_[j]; }
  // The largest squared residual of the friction that was likeliest before this frame, over its variance.
  double surprise() const noexcept { return frame_.surprise; }

  // The forces have moved by this share of what decorrelates errors.
  void decorrelate(double moved) noexcept;

  const FrictionGrid& grid() const noexcept { return grid_; }

 private:
  template <class To>
  void change(double probability, To to) noexcept;
  template <bool kWeighed>
  void take(Evidence by, std::span<const double> residual, double common, double noise) noexcept;

  static constexpr std::size_t kEvidence = 5;
  using PerFriction = std::array<double, FrictionGrid::kMost>;

  // The error that frames have in common, over its standard deviation, by each friction; what frames so far
  // leave open of it, as a variance. `if_changed`: of this frame, if friction has just changed.
  struct CommonError {
    PerFriction mean{}, if_changed{};
    double variance = 1;
    double usual = 0;      // its standard deviation over late frames; 0: none yet
    bool weighed = false;  // in this frame
  };

  const FrictionPosteriorOptions options_;
  FrictionGrid grid_;
  const double most_prior_;  // of one point
  PerFriction same_{}, changed_{};
  PerFriction held_{};  // nats that a load which was held has taken from each friction
  std::array<bool, FrictionGrid::kMost> has_changed_{};
  struct ThisFrame {
    double surprise = 0;
  };
  ThisFrame frame_;
  std::array<CommonError, kEvidence> errors_;
};

}  // namespace slipd
