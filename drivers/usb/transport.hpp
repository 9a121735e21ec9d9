// Which USB device a driver opens, and how. One opener uses libusb; tests have one without a bus.
#pragma once

#include <functional>
#include <string>

#include "drivers/decode/profile.hpp"
#include "drivers/decode/stream_driver.hpp"

namespace slipd::usb {

using decode::OpenedDevice;
using decode::ReceivedBytes;
using decode::ReceiveResult;
using decode::Transport;

// Selects one of several devices that match a profile.
struct DeviceSelector {
  std::string serial;  // empty: any
  std::string port;    // as in /sys/bus/usb/devices: "1-2.3"; empty: any
};

// Set-up thread. Finds, opens and starts the device. Throws DriverError.
using Opener = std::function<OpenedDevice(const decode::Profile&, const DeviceSelector&)>;
OpenedDevice open_device(const decode::Profile& profile, const DeviceSelector& selector);

}  // namespace slipd::usb
