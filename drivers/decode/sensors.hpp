// The sensors of one device that share one stream of packets (USB, HID, Modbus): one decoder each. One packet
// can complete frames of several sensors; they are returned one at a time. The set-up thread constructs it,
// the acquire thread uses it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "drivers/decode/decoder.hpp"

namespace slipd::decode {

class Sensors {
 public:
  // Each setup's option `sensor` selects its sensor. Throws DriverError where two are the same or the device
  // has fewer.
  Sensors(const Profile& profile, const std::vector<SensorSetup>& setups);

  // `frame`, `corrupt`, or `timeout` where the packet completed no frame. slots[i] belongs to setup i.
  ReadResult take(std::uint32_t id, std::span<const std::uint8_t> bytes, std::int64_t time_ns,
                  std::span<FrameSlot> slots) noexcept;

  // The next frame that the last take() completed, or `timeout`. Call it until `timeout` before the next
  // take().
  ReadResult next_ready() noexcept;

  void mark_packet_lost() noexcept;  // of an unknown sensor: applies to all
  void reset() noexcept;

  // See DeviceDriver::why_no_frames. `packets`: what the bus calls them.
  std::string why_no_frames(const std::string& packets) const;
  const std::vector<SensorInfo>& info() const noexcept { return info_; }

 private:
  std::vector<SensorInfo> info_;
  std::vector<Decoder> decoders_;
  std::vector<bool> ready_;
};

}  // namespace slipd::decode
