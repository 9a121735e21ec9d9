// What a USB device answers on endpoint 0: descriptors from its model, the standard requests, its own.
#pragma once

#include <string>

#include "tests/support/devices/device_model.hpp"

namespace slipd::devices {

class UsbRequests {
 public:
  UsbRequests(const DeviceModel& model, HostState& host, std::string serial);

  // `setup`: the eight bytes of a request. Data to the host (empty for requests without), or nothing for a
  // stall.
  std::optional<Bytes> control(std::span<const std::uint8_t> setup);

  // How USB/IP describes the device, with or without its interfaces.
  Bytes usbip_record(bool with_interfaces) const;

 private:
  std::optional<Bytes> descriptor(std::uint16_t which) const;
  Bytes device_descriptor() const;

  const DeviceModel& model_;
  HostState& host_state_;
  std::string serial_;
  Bytes configuration_;
};

}  // namespace slipd::devices
