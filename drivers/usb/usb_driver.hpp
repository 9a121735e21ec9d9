// Tactile sensors on USB: bulk transfers, cut into packets as the profile describes. Serial ports (CDC-ACM)
// are read without the kernel's tty layer, which would delay bytes and give no time of arrival.
#pragma once

#include <vector>

#include "drivers/decode/stream_driver.hpp"
#include "drivers/usb/transport.hpp"

namespace slipd::usb {

class UsbDriver final : public decode::StreamDriver {
 public:
  // Throws DriverError for a profile, device or options that cannot work. `opener` opens the device; tests
  // replace it.
  explicit UsbDriver(const std::vector<SensorSetup>& sensors, Opener opener = usb::open_device);

 private:
  OpenedDevice open_device() override { return opener_(profile(), selector_); }

  const DeviceSelector selector_;
  const Opener opener_;
};

}  // namespace slipd::usb
