// A USB device's answers on endpoint 0: descriptors from its model, standard requests, class and vendor
// requests.
#pragma once

#include <string>

#include "tests/devices/device_model.hpp"

namespace slipd::devices {

class UsbRequests {
 public:
  UsbRequests(const DeviceModel& model, HostState& host, std::string serial);

  // `setup`: the eight bytes of a request. Returns data to the host (empty for requests without data), or
  // nothing for a stall.
  std::optional<Bytes> control(std::span<const std::uint8_t> setup);

  // The device's description in USB/IP, with or without its interfaces.
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
