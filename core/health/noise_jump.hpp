// Whether one channel has become much noisier than it was in this contact, while the others have not: a loose
// wire, a broken reference. Vibrations of a slip are in all channels. Estimate thread; plain state, nothing
// allocates.
#pragma once

#include <array>
#include <cstdint>

#include "core/health/probes.hpp"
#include "core/health/usual.hpp"

namespace slipd {

// Checked with `slipd-lab faults` and on recordings of real sensors.
struct NoiseJumpOptions {
  // Mean squared step from frame to frame of the noisy channel, of what is usual, while that of the others is
  // within kBeyondUsual; 10 … 1000. Too small: vibrations and quick loads are called noise. Too large: noise
  // passes.
  double jumped = 30;
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
