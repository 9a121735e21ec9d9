// Finding the one USB device that is meant. Set-up thread. Each search begins with a context of its own, so
// that what has come or gone is known whether or not the machine tells of it (udev may not run in a
// container).
#pragma once

#include <memory>
#include <string>

#include "drivers/usb/wire.hpp"

struct libusb_context;
struct libusb_device_handle;

namespace slipd::usb {

struct ExitsContext {
  void operator()(libusb_context* context) const noexcept;
};
struct ClosesDevice {
  void operator()(libusb_device_handle* handle) const noexcept;
};

struct Found {
  std::unique_ptr<libusb_context, ExitsContext> context;  // outlives the handle
  std::unique_ptr<libusb_device_handle, ClosesDevice> handle;
  std::string id, port, serial;  // "16c0:0483", "1-2.3"

  std::string name() const { return "USB device " + id + " at " + port; }
};

// Throws DriverError, which says what there is.
Found find_device(const decode::UsbMatch& match, const Which& which);

}  // namespace slipd::usb
