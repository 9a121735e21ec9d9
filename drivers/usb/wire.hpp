// What the driver needs of a USB device that is open: pieces of bytes as they arrive, and a way to say things
// to it. There is one implementation on libusb; tests have one without a bus.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "drivers/decode/profile.hpp"

namespace slipd::usb {

struct Arrival {
  std::span<const std::uint8_t> bytes;  // valid until the next receive()
  std::int64_t time_ns = 0;             // CLOCK_MONOTONIC, when the transfer was complete
};

enum class Got : std::uint8_t {
  bytes,
  nothing,  // until give_up_ns
  spoilt,   // a transfer failed and what it had is lost; the next ones go on
  gone      // the device is; only closing is left
};

class Wire {
 public:
  virtual ~Wire() = default;

  // Acquire thread.
  virtual Got receive(Arrival& out, std::int64_t give_up_ns) noexcept = 0;

  // Acquire thread. Says the profile's start messages again, without waiting for an answer.
  virtual void start_again() noexcept = 0;
};

// Which of several devices that match; empty: the only one.
struct Which {
  std::string serial;
  std::string port;  // as in /sys/bus/usb/devices: "1-2.3"
};

struct Opened {
  std::unique_ptr<Wire> wire;
  std::string place;  // for people
  std::string serial;
};

// Set-up thread. The device is started. Throws DriverError.
using Opener = std::function<Opened(const decode::Profile&, const Which&)>;
Opened open_device(const decode::Profile& profile, const Which& which);

}  // namespace slipd::usb
