// The sensors of one device whose packets come over one line (USB, HID): a decoder for each, and frames told
// one at a time though one packet may finish those of several. Acquire thread; made by the set-up thread.
#pragma once

#include <span>
#include <vector>

#include "drivers/decode/decoder.hpp"

namespace slipd::decode {

class Sensors {
 public:
  // By each setup's option `sensor`. Throws DriverError where two are the same or the device has fewer.
  Sensors(const Profile& profile, const std::vector<SensorSetup>& setups);

  // `frame`, `corrupt`, or `timeout` where the packet finished nothing. slots[i] is that of setup i.
  ReadResult take(std::uint32_t id, std::span<const std::uint8_t> bytes, std::int64_t time_ns,
                  std::span<FrameSlot> slots) noexcept;

  // The next frame that take() left to be told, or `timeout`. Before any other packet is taken.
  ReadResult next_ready() noexcept;

  void spoil() noexcept;  // a packet was lost on the way
  void reset() noexcept;
  const std::vector<SensorInfo>& info() const noexcept { return info_; }

 private:
  std::vector<SensorInfo> info_;
  std::vector<Decoder> decoders_;
  std::vector<bool> ready_;
};

}  // namespace slipd::decode
