// Tactile sensors on USB: bulk transfers, cut into packets as the profile says. Those that look like serial
// ports (CDC-ACM) are spoken to without the kernel's tty, which would keep bytes back and tell no time.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "driver_api/driver.hpp"
#include "drivers/decode/framer.hpp"
#include "drivers/decode/sensors.hpp"
#include "drivers/usb/wire.hpp"

namespace slipd::usb {

class UsbDriver final : public DeviceDriver {
 public:
  // Throws DriverError for a profile, device or options that cannot work. `opener`: tests have a device of
  // their own.
  explicit UsbDriver(const std::vector<SensorSetup>& sensors, Opener opener = open_device);

  DeviceInfo open() override;
  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override;
  void close() noexcept override { wire_.reset(); }

 private:
  ReadResult decode_held(std::span<FrameSlot> slots) noexcept;
  void wake_if_silent(std::int64_t now_ns) noexcept;

  decode::Profile profile_;
  Which which_;
  Opener opener_;
  decode::Sensors sensors_;
  decode::Framer framer_;
  std::unique_ptr<Wire> wire_;
  std::int64_t arrived_ns_ = 0;  // of what the framer has last
  std::int64_t heard_ns_ = 0;    // or asked
};

}  // namespace slipd::usb
