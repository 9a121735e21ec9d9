// Finds the one USB device that a profile and a configuration describe. Set-up thread. Each search creates
// its own libusb context, so that it sees devices that were plugged in or out even without udev (in a
// container).
#pragma once

#include <memory>
#include <string>

#include "drivers/usb/transport.hpp"

struct libusb_context;
struct libusb_device_handle;

namespace slipd::usb {

struct ExitsContext {
  void operator()(libusb_context* context) const noexcept;
};
struct ClosesDevice {
  void operator()(libusb_device_handle* handle) const noexcept;
};

struct FoundDevice {
  std::unique_ptr<libusb_context, ExitsContext> context;  // outlives the handle
  std::unique_ptr<libusb_device_handle, ClosesDevice> handle;
  std::string id;      // vendor and product: "16c0:0483"
  std::string port;    // as in /sys/bus/usb/devices: "1-2.3"
  std::string serial;  // empty: it has none

  std::string name() const { return "USB device " + id + " at " + port; }
};

// Throws DriverError, which lists the devices found.
FoundDevice find_device(const decode::UsbMatch& match, const DeviceSelector& selector);

}  // namespace slipd::usb
