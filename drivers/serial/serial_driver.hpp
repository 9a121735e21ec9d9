// Tactile sensors on a serial line, described by a profile: they send by themselves, or answer requests.
#pragma once

#include <string>
#include <vector>

#include "drivers/decode/stream_driver.hpp"

namespace slipd::serial {

class SerialDriver final : public decode::StreamDriver {
 public:
  // Throws DriverError for a profile, device or options that cannot work.
  explicit SerialDriver(const std::vector<SensorSetup>& sensors);

 private:
  decode::OpenedDevice open_device() override;

  std::string path_;
  decode::SerialLine line_;
};

}  // namespace slipd::serial
