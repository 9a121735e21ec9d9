// The posterior of friction: log weights on an even grid of log mu (docs/methods.md §28). A
// friction that lost its weight keeps a floor, so that later frames can bring it back. Estimate thread; fixed
// memory, nothing allocates.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "core/numeric/posterior_sums.hpp"
#include "core/reading/method/friction_prior.hpp"

namespace slipd {

// Checked with `slipd-lab histories --grasps 400` (grids of 56) and `slipd-lab tradeoff --layouts 4,wrench`
// (of 224). A nat is a unit of a natural logarithm of likelihood.
struct FrictionGridOptions {
  // The grid's ends, mu; 0.01 … 0.1 and 1 … 5. Too narrow: frictions outside come out as the end. Too wide:
  // the step grows, and with it what no frame can distinguish.
  double min_friction = 0.04;
  double max_friction = 2.2;
  // The most that one frame counts against one friction; nats, 5 … 50. Too small: gross slip is learnt
  // slowly. Too large: one bad frame decides.
  double max_frame_nats = 20;
  // A friction this far behind the likeliest is refuted: it held more, or looks otherwise; nats, 3 … 15. Too
  // small: foundations of frictions that may still be right are overwritten when friction falls. Too large:
  // those that are wrong are kept.
  double refuted_nats = 8;
  // Floors behind the prior for frictions below and above the likeliest; nats, 5 … 50. Too small: noise
  // brings a refuted friction back. Too large: a change is learnt late. The floor below is the higher one:
  // friction that falls is learnt sooner than friction that rises.
  double floor_below_nats = 12;
  double floor_above_nats = 20;
  // The most that the prior counts against a friction; nats, 10 … 100. Too small: the scene's range says
  // little. Too large: a friction far outside is never learnt.
  double max_prior_nats = 40;
  // The most by which the likeliest friction leads its neighbours; nats, 2 … 20. Too small: friction never
  // becomes sharper than the grid. Too large: the next frame cannot move it.
  double max_lead_nats = 8;
  // Floor of friction's sigma, relative, 0 … 0.1: contacts are not as even as their model. Too small: sigma
  // is less than the error. Too large: sharp frames are wasted.
  double sigma_floor = 0.02;
  // Floor of the sigma of |Q|/P, 1e-6 … 0.01: what gains and rounding of the taxels leave of the forces'
  // ratio, also of a sensor that shows no noise. Too small: a margin without shear is given as exact. Too
  // large: sigma is more than the error on good sensors.
  double load_floor = 5e-4;
  // Friction whose sigma is below this, relative, gives the margin in closed form; 0 … 0.3. Too small: costs
  // time. Too large: 1/mu is taken for linear where it is not.
  double sharp_sigma = 0.1;
  // Share of the weight within two steps of the likeliest friction from which a parabola through three points
  // replaces the sums; 0.9 … 1. Too small: a second peak is overlooked. Too large: mean and sigma jump from
  // point to point.
  double peak_share = 0.97;
  // The least curvature of that parabola; nats over step^2, > 0. Too small: a flat top is taken for a peak.
  double min_curvature_nats = 0.5;
};

class FrictionGrid {
 public:
  static constexpr std::size_t kMost = 224;

  // count: points of the grid, 2 … kMost.
  FrictionGrid(const FrictionPrior& prior, std::size_t count, const FrictionGridOptions& options = {});

  // Back to the prior.
  void reset() noexcept { log_weight_ = log_prior_; }

  // Forgets towards the prior: keep = 1 changes nothing, keep = 0 is reset().
  void fade(double keep) noexcept;

  // `nats` >= 0 of evidence against point j, at most max_frame_nats.
  void take(std::size_t j, double nats) noexcept {
    log_weight_[j] -= std::min(nats, options_.max_frame_nats);
  }

  // Friction has fallen, and by how much is not known: all below the likeliest are at most `nats` behind it.
  void open_below(double nats) noexcept;

  // After each frame: the likeliest gets 0, all floors are applied.
  void normalise() noexcept;

  std::size_t count() const noexcept { return count_; }
  double friction(std::size_t j) const noexcept { return friction_[j]; }
  std::span<const double> frictions() const noexcept { return std::span(friction_).first(count_); }
  bool refuted(std::size_t j) const noexcept { return log_weight_[j] < -options_.refuted_nats; }
  std::size_t likeliest() const noexcept;

  // mu, with its floor of sigma.
  MeanSigma friction() const noexcept;

  // 1/mu, and its standard deviation.
  MeanSigma inverse_friction() const noexcept;

  // Gamma = 1 - load/mu, within 0 … 1, for load = |Q|/P >= 0 with its sigma.
  MeanSigma margin(double load, double load_sigma) const noexcept;

  // Between two points, in log mu.
  double step() const noexcept { return step_; }

 private:
  using PerFriction = std::array<double, kMost>;

  const FrictionGridOptions options_;
  const std::size_t count_;
  const double step_;
  PerFriction friction_{}, log_prior_{}, log_weight_{};
};

}  // namespace slipd
