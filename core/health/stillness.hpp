// Whether values that change from frame to frame have stopped to: a frozen sensor, a dead channel, a dead
// row. It is judged by what the same values did before. Values that never had noise, and quantised values
// that often repeat, may stand still. Estimate thread; plain state, nothing allocates.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/health/usual.hpp"

namespace slipd {

// What a group of values did from one frame to the next.
struct GroupChange {
  std::size_t values = 0;   // of the group
  std::size_t changed = 0;  // values that are not what they were
  std::size_t turned = 0;   // of these, those that changed the other way than the last time
};

// Evidence that a stillness is not chance; nats, 12 … 40. Chance makes e^-20 = 2e-9 of it. Too small: false
// alarms. Too large: dead groups of few values are noticed late.
inline constexpr double kSureNats = 20;

class Stillness {
 public:
  // One frame. Returns whether the group stands still though it should not: beyond chance, and for longer
  // than kBeyondUsual times any run that was taken for chance, since some devices repeat frames.
  bool update(const GroupChange& now) noexcept;

  // The group stood still, or was empty, for a reason that is known: nothing is learnt from this frame.
  void skip() noexcept {
    run_ = 0;
    called_ = false;
  }

  // The values have noise.
  bool noisy() const noexcept { return frames_ >= learning_frames() && turning_ >= kNoiseTurns; }

  // Mean share of values that change in a frame, 0 … 1.
  double changing() const noexcept { return changing_; }

  // Frames in a row in which nothing changed.
  std::uint32_t run() const noexcept { return run_; }

 private:
  std::uint32_t frames_ = 0;   // that changed, up to kMemoryFrames
  std::uint32_t run_ = 0;      // frames without a change, up to now
  std::uint32_t longest_ = 0;  // run before that was taken for chance
  bool called_ = false;        // this run was called out
  double changing_ = 0;        // mean share of values that change in a frame
  double turning_ = 0;         // mean share of changes that turn
};

}  // namespace slipd
