// |Q|/P over the frames of a grasp, the share of the normal force that a contact carries as shear, where a
// sensor gives forces only: that of a straight line through the last frames. It also detects gross slip
// (docs/methods.md §28). Estimate thread; fixed memory, nothing allocates.
#pragma once

#include <optional>

#include "core/numeric/posterior_sums.hpp"
#include "core/patch/patch.hpp"
#include "core/sliding/sliding.hpp"

namespace slipd {

// Sigmas are standard deviations of one frame's |Q|/P, or of what is named. Checked with `slipd-lab tradeoff
// --layouts 4,wrench`, rows over time.
struct TractionRatioOptions {
  // Frames that the line keeps when the load has turned; frames, 2 … learning_frames(). Too small: the slope
  // after it is noise. Too large: frames before the turn bend it.
  std::uint32_t frames_after_turn = 6;
  // Residual of one frame at which the line begins anew with it; sigmas, 3 … 10. Too small: noise cuts the
  // line. Too large: a jump is followed late.
  double jump_sigmas = 4;
  // |Q|/P that stays this even while P falls is gross slip, and P that rises by more has risen; relative,
  // 0.002 … 0.1. Too small: a slide on a rough surface is missed, and noise restarts it. Too large: unloading
  // both forces passes for a slide, and the load of a grip that still closes counts as one before.
  double plateau = 0.015;
  // P has to fall by this much for a plateau to be gross slip; relative, 0.01 … 0.5. Too small: a slow drift
  // passes for a slide. Too large: short slides are missed.
  double plateau_fall = 0.06;
  // Floor of the sigma of what friction holds, relative to |Q|/P; 0 … 0.05. Too small: a frame without noise
  // refutes a friction that is a little less. Too large: gross slip bounds friction loosely.
  double held_floor_mean = 0.005;
};

class TractionRatioFilter {
 public:
  explicit TractionRatioFilter(const TractionRatioOptions& options = {}) noexcept : options_(options) {}

  // A new grasp.
  void reset() noexcept {
    state_ = {};
    frame_ = {};
  }

  // One frame in contact, in order of time.
  void update(const ContactPatch& patch) noexcept;

  // |Q|/P now, dimensionless, >= 0.
  const MeanSigma& now() const noexcept { return frame_.now; }

  // |Q|/P that friction holds by now: the running mean, for of the many frames of a slide the noisiest would
  // else decide.
  MeanSigma held() const noexcept;

  // Whether one frame's |Q|/P is, within its sigma, the highest of this grasp that detect_slide() has seen.
  bool is_highest(double load, double sigma) const noexcept;

  // Gross slip by Coulomb's law.
  struct Slide {
    double load = 0;   // |Q|/P
    double sigma = 0;  // standard deviation of log mu that it shows
  };
  // Once after each update(). The object slides as a whole: its field is coherent and keeps its direction,
  // and either the taxels' pattern is seen to move (one reading a block), or |Q|/P, having risen while P did
  // not, is even while P falls (one a frame). (A contact that sticks keeps |Q|/P even as well while both rise
  // from nothing, and while a gripper that overshot relaxes.) `sliding`: of the same sensor, at most a frame
  // old.
  std::optional<Slide> detect_slide(const SlidingVerdict& sliding = {}) noexcept;

 private:
  // Straight line through the last frames, and the running mean of residuals that says when it has turned.
  struct Line {
    double slope = 0;          // per frame
    std::uint32_t frames = 0;  // that level and slope come from
    double residual = 0;
  };
  // The resultant, N.
  struct Shear {
    double x_n = 0, y_n = 0;
  };
  struct Load {
    double ratio = 0;     // |Q|/P
    double normal_n = 0;  // P
  };
  // Where an even |Q|/P began.
  struct Plateau {
    Load load;
    Shear shear;
  };
  struct State {
    Line line;
    double level = 0;        // of the line at the newest frame
    double mean = 0;         // running mean of |Q|/P
    double normal_n = 0;     // running mean of P
    Shear shear;             // running mean
    double highest = 0;      // |Q|/P, less its sigma
    Load at_last_grip_rise;  // when P last rose
    std::optional<Plateau> plateau;
    std::optional<Shear> moving;  // when the pattern began to move
    std::uint32_t block = 0;      // the last one that was read
  };
  struct ThisFrame {
    MeanSigma now;              // the line's level
    double sigma = 0;           // of its |Q|/P
    double normal_sigma_n = 0;  // of the running mean of P
  };

  // Both return the line's level now.
  MeanSigma restart_line(const MeanSigma& frame) noexcept;
  MeanSigma extend_line(double residual, double sigma) noexcept;
  bool is_steady(const Shear& since) const noexcept;
  std::optional<Slide> read_moving(const SlidingVerdict& sliding) noexcept;
  std::optional<Slide> read_plateau() noexcept;

  const TractionRatioOptions options_;
  State state_;
  ThisFrame frame_;
};

}  // namespace slipd
