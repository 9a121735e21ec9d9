// Tactile sensors on a CAN bus: boards that send their scans in several frames, distinguished by a number in
// their identifiers. One driver is one bus; each sensor is one board.
//
// A board that lost its power comes back silent, and nothing on the bus reports that. Therefore the driver
// sends the start messages again whenever a board has sent nothing for the profile's keep_alive_ms.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "driver_api/driver.hpp"
#include "drivers/can/can_socket.hpp"
#include "drivers/decode/decoder.hpp"

namespace slipd::can {

class CanDriver final : public DeviceDriver {
 public:
  using Opener = std::function<Socket(const std::string& interface, const std::vector<std::uint32_t>& ids)>;

  // Throws DriverError for a profile or options that cannot work. `opener` opens the bus; tests replace it.
  explicit CanDriver(const std::vector<SensorSetup>& sensors, Opener opener = open_interface);

  DeviceInfo open() override;
  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override;
  void close() noexcept override;
  std::string why_no_frames() const override;

 private:
  struct Message {
    std::uint32_t id;
    std::vector<std::uint8_t> bytes;
  };
  struct Board {
    unsigned number;
    decode::Decoder decoder;
    std::vector<Message> start, stop;
    std::int64_t last_activity_ns = 0;  // of its last packet or of the last start messages to it
  };

  void restart_silent_boards(std::int64_t now_ns) noexcept;
  ReadResult take(const ReceivedFrame& received, std::span<FrameSlot> slots) noexcept;

  decode::Profile profile_;
  std::string interface_;
  Opener opener_;
  std::vector<Board> boards_;
  Socket socket_;
};

}  // namespace slipd::can
