// Whether a clear contact goes on from one frame to the next: another sensor's frames, exchanged or turned
// axes and a wrong unit that begin in mid-grasp change in one frame what a contact changes over many.
// Estimate thread; plain state, nothing allocates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/health/health.hpp"
#include "core/health/probes.hpp"
#include "core/health/usual.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

// Checked with `slipd-lab faults` and on recordings of real sensors.
struct ContinuityOptions {
  // Unlikeness of two frames' pressures (PatternChange) that no contact makes, if it exceeds kBeyondUsual
  // times what late frames and noise make; 0.05 … 0.5. Too small: rolling contacts jump. Too large: another
  // contact's frames are believed.
  double least_unlike = 0.15;
  // The same of frames at most fast_step_s apart; 0.01 … 0.2: less happens in a shorter time. Frames that are
  // less unlike are of one contact: its pressures all changed by kWrongScale are of a wrong unit.
  double least_unlike_fast = 0.02;
  // Shear that turns in one frame (kTurned) does so by at least this share of the normal force, 0.02 … 0.3,
  // in frames at most so long apart; s, 1e-3 … 0.01: what is held has mass. Too small: knocks are called
  // faults. Too large: exchanged axes are believed.
  double least_turn_share = 0.05;
  double fast_step_s = 3e-3;
};

// What is kept of a frame for the next one.
struct SeenFrame {
  std::int64_t time_ns = 0;
  ContactNumbers contact;
  bool believed = true;  // it was not refused

  // Its force is far above the noise.
  bool clear() const noexcept;
  // So is its shear.
  bool directed() const noexcept;
};

class Continuity {
 public:
  explicit Continuity(const ContinuityOptions& options) noexcept : options_(options) {}

  // A frame that is not believed for another reason: the next one is not compared with it.
  void skip() noexcept { skipped_ = true; }

  // Any other frame, with the one before; none: it is the first. A jump lasts until the object is let go: its
  // force is not clear any more, or the kWrongScale-th part of what it was. pattern: how the pressure changed
  // since, in so many probes. Returns good, jump or wrong_scale.
  Health update(const SeenFrame& now, const std::optional<SeenFrame>& before, const PatternChange& pattern,
                std::size_t probes) noexcept;

 private:
  // How one frame follows another.
  struct Step {
    const SeenFrame& now;
    const SeenFrame& before;
    const PatternChange& pattern;
    std::size_t probes;
    bool fast;  // at most fast_step_s
  };
  bool unlike(const Step& step) noexcept;
  bool turned(const Step& step) noexcept;
  bool scaled(const Step& step) noexcept;

  const ContinuityOptions options_;
  bool skipped_ = false;     // the frame before
  double usual_step_s_ = 0;  // between frames; 0: not known
  UsualValue unlikeness_, turn_;
  double broken_at_n_ = 0;    // the normal force at which this contact jumped; 0: it did not
  double scaled_from_n_ = 0;  // the normal force before all pressures were scaled; 0: they were not
};

}  // namespace slipd
