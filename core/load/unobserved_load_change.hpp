// How far the forces moved from one frame to the next. The friction filter takes them to have gone there in a
// straight line. Where many frames were skipped, or a grip is fast for its sensor, they may have gone another
// way: a reversal or a regrip between two frames leaves a contact that nobody expects. The margin's deviation
// grows with what was not seen. Estimate thread; fixed memory.
#pragma once

#include "core/load/load_path.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

class UnobservedLoadChange {
 public:
  // A share of the normal force that moves between two frames at most, so that nothing can hide in between.
  // Less: frames of a fast grip that are all there widen sigma. More: a reversal hides (`slipd-lab
  // overload`).
  static constexpr double kSeen = 0.05;
  // Standard deviation of the margin for forces that moved by all of the normal force. Less: margins after a
  // gap lie outside of their sigma more often than others. More: fewer frames are answered (`slipd-lab
  // overload`).
  static constexpr double kSigmaOfMotion = 0.05;
  // Frames after which it counts for 1/e: so long the shape of frames determines the contact anew.
  static constexpr double kFadeFrames = 100;

  void forget() noexcept { moved_ = 0; }

  // One frame in contact: `patch`, as measured, and its step. `friction`: shear that moves by friction times
  // normal force counts as much as a normal force that moves by all of it.
  void update(const ContactPatch& patch, const LoadStep& step, double friction) noexcept;

  // Of the margin, standard deviation.
  double sigma() const noexcept { return kSigmaOfMotion * moved_; }

 private:
  double moved_ = 0;  // share of the normal force, the most of late, faded
};

}  // namespace slipd
