// Whether one channel has become much noisier than it was in this contact, while the others have not: a loose
// wire, a broken reference. Vibrations of a slip are in all channels. Estimate thread; plain state, nothing
// allocates.
#pragma once

#include <array>
#include <cstdint>

#include "core/health/probes.hpp"
#include "core/health/usual.hpp"

namespace slipd {

class NoiseJump {
 public:
  using Channels = std::array<ChannelChange, kChannels>;

  // One frame. Returns whether one of its channels is too noisy: by kWrongScale, while the others are within
  // kBeyondUsual. Starts anew where there is no contact.
  bool update(const Channels& channels, bool in_contact) noexcept;

 private:
  std::array<double, kChannels> usual_pa2_{};
  std::uint32_t frames_ = 0;  // learnt from in this contact
  std::uint32_t run_ = 0;     // frames in a row in which a channel was too noisy
};

}  // namespace slipd
