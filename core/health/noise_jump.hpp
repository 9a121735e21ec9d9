// Whether one channel has become much noisier than it was in this contact, while the others have not: a loose
// wire, a broken reference. Vibrations of a slip are in all channels. Estimate thread; plain state, nothing
// allocates.
#pragma once

#include <array>
#include <cstdint>

#include "core/health/probes.hpp"

namespace slipd {

// Checked with `slipd-lab faults` and on recordings of real sensors.
struct NoiseJumpOptions {
  // Frames over which noise is averaged; of half as many of a contact on something is said; frames, 32 …
  // 2000. Too small: the beginning of a contact decides. Too large: nothing is said of short contacts.
  std::uint32_t memory_frames = 64;
  std::uint32_t learning_frames() const noexcept { return memory_frames / 2; }
  // Mean squared step from frame to frame of the noisy channel, and of the others at most, of what is usual;
  // 10 … 1000 and 1.5 … 5. Too small: vibrations and quick loads are called noise. Too large: noise passes.
  double jumped = 30;
  double quiet = 3;
  // Share of changes that turn, from which steps are noise and no load; 0.3 … 0.6. Independent noise: 2/3.
  double noise_turns = 0.4;
  // Frames in a row; frames, 2 … 10. Too small: one step is called noise. Too large: late.
  std::uint32_t frames = 3;
};

class NoiseJump {
 public:
  using Channels = std::array<ChannelChange, kChannels>;

  // One frame. Returns whether one of its channels is too noisy. Starts anew where there is no contact.
  bool update(const Channels& channels, bool in_contact, const NoiseJumpOptions& options) noexcept;

 private:
  std::array<double, kChannels> usual_pa2_{};
  std::uint32_t frames_ = 0;  // learnt from in this contact
  std::uint32_t run_ = 0;     // frames in a row in which a channel was too noisy
};

}  // namespace slipd
