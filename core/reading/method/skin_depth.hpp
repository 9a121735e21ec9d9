// How deep taxels lie, as far as it is known: a Gaussian of the log of the depth over the nominal one. What
// the frames of a grasp show of it is added to what was known before (docs/methods.md §23.8). Estimate
// thread; nothing allocates.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/contact/scene.hpp"
#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"

namespace slipd {

// Of the log of a depth over another one.
struct LogDepth {
  double mean = 0;
  double sigma = 0;  // standard deviation, >= 0
};

class SkinDepth {
 public:
  // depth_m: nominal, >= 0. sigma: of its log; 0: the depth is exact.
  SkinDepth(double depth_m, double sigma) noexcept : depth_m_(depth_m), prior_sigma_(sigma) { forget(); }

  bool open() const noexcept { return depth_m_ > 0 && prior_sigma_ > 0; }
  // Further frames change little.
  bool settled() const noexcept { return open() && now_.sigma <= std::min(kUnevenShare, prior_sigma_); }
  const LogDepth& now() const noexcept { return now_; }
  // By all frames so far, m.
  double depth_m() const noexcept { return depth_m(now_.mean); }
  // Of the log over nominal, m.
  double depth_m(double log) const noexcept { return depth_m_ * std::exp(log); }

  // What is known together with a frame that shows the log of the depth over nominal as `frame.mean`.
  LogDepth with(const LogDepth& frame) const noexcept {
    const double known = 1 / (now_.sigma * now_.sigma), shown = 1 / (frame.sigma * frame.sigma);
    return limited(
        {(known * now_.mean + shown * frame.mean) / (known + shown), 1 / std::sqrt(known + shown)});
  }
  // No farther from nominal than that is believed, and no better known than frames can show.
  LogDepth limited(const LogDepth& known) const noexcept {
    return {std::clamp(known.mean, -most(), most()),
            std::max(std::min(kUnevenShare, prior_sigma_), known.sigma)};
  }
  // The farthest from nominal that is believed.
  double most() const noexcept { return kClearSigmas * prior_sigma_; }
  void take(const LogDepth& known) noexcept { now_ = known; }
  // A new grasp.
  void forget() noexcept { now_ = {0, prior_sigma_}; }

 private:
  const double depth_m_, prior_sigma_;
  LogDepth now_;
};

}  // namespace slipd
