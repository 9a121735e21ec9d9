// Tactile sensors on USB: bulk transfers, cut into packets as the profile describes. Serial ports (CDC-ACM)
// are read without the kernel's tty layer, which would delay bytes and give no time of arrival.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "driver_api/driver.hpp"
#include "drivers/decode/framer.hpp"
#include "drivers/decode/sensors.hpp"
#include "drivers/usb/transport.hpp"

namespace slipd::usb {

class UsbDriver final : public DeviceDriver {
 public:
  // Throws DriverError for a profile, device or options that cannot work. `opener` opens the device; tests
  // replace it.
  explicit UsbDriver(const std::vector<SensorSetup>& sensors, Opener opener = open_device);

  DeviceInfo open() override;
  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override;
  void close() noexcept override { transport_.reset(); }
  std::string why_no_frames() const override { return sensors_.why_no_frames("packets"); }

 private:
  ReadResult decode_held(std::span<FrameSlot> slots) noexcept;
  void restart_if_silent(std::int64_t now_ns) noexcept;

  decode::Profile profile_;
  DeviceSelector selector_;
  Opener opener_;
  decode::Sensors sensors_;
  decode::Framer framer_;
  std::unique_ptr<Transport> transport_;
  std::int64_t arrived_ns_ = 0;        // of the bytes that the framer got last
  std::int64_t last_activity_ns_ = 0;  // of the last transfer or of the last start messages
};

}  // namespace slipd::usb
