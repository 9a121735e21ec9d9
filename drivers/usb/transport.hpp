// The driver's interface to an open USB device: it receives transfers and sends start messages. One
// implementation uses libusb; tests have one without a bus.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "drivers/decode/profile.hpp"

namespace slipd::usb {

// One transfer from the device.
struct ReceivedBytes {
  std::span<const std::uint8_t> bytes;  // valid until the next receive()
  std::int64_t time_ns = 0;             // CLOCK_MONOTONIC, when the transfer was complete
};

enum class ReceiveResult : std::uint8_t {
  bytes,           // a transfer has arrived
  timeout,         // none until give_up_ns
  transfer_error,  // a transfer failed and its bytes are lost; later ones can arrive
  disconnected     // the device is gone; only closing remains
};

class Transport {
 public:
  virtual ~Transport() = default;

  // Acquire thread.
  virtual ReceiveResult receive(ReceivedBytes& out, std::int64_t give_up_ns) noexcept = 0;

  // Acquire thread. Sends the profile's start messages again, without waiting for answers.
  virtual void restart() noexcept = 0;
};

// Selects one of several devices that match a profile.
struct DeviceSelector {
  std::string serial;  // empty: any
  std::string port;    // as in /sys/bus/usb/devices: "1-2.3"; empty: any
};

struct OpenedDevice {
  std::unique_ptr<Transport> transport;
  std::string place;   // the port, for people
  std::string serial;  // empty: it has none
};

// Set-up thread. Finds, opens and starts the device. Throws DriverError.
using Opener = std::function<OpenedDevice(const decode::Profile&, const DeviceSelector&)>;
OpenedDevice open_device(const decode::Profile& profile, const DeviceSelector& selector);

}  // namespace slipd::usb
