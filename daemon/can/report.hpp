// State and counters of the CAN output. Written by the CAN thread, read by io through a Latest.
#pragma once

#include <cstdint>
#include <string_view>

namespace slipd::can {

// State of the interface and its controller.
enum class Bus : std::uint8_t {
  absent,   // there is no such interface, or it cannot be opened
  down,     // it is not up
  up,       // it is up, error-active
  warning,  // error counters above the warning limit
  passive,  // error-passive
  bus_off   // disconnected from the bus by errors
};

// The name on the socket. Called from any thread.
constexpr std::string_view to_string(Bus bus) noexcept {
  constexpr std::string_view kWords[] = {"absent", "down", "up", "error_warning", "error_passive", "bus_off"};
  return kWords[static_cast<std::size_t>(bus)];
}

// The present state, and counters since the start.
struct Report {
  Bus bus = Bus::absent;
  // errno of the last failed open; 0: none was tried.
  int error = 0;
  // Messages that the kernel accepted.
  std::uint64_t sent = 0;
  // Attempts for which the kernel's queue had no room; the newest value is sent later.
  std::uint64_t full = 0;
  // Attempts that the kernel refused for other reasons.
  std::uint64_t failed = 0;
  // Error frames of the controller.
  std::uint64_t bus_errors = 0;
  // Times that the controller went off the bus.
  std::uint64_t bus_offs = 0;
  // Times that the interface was opened again.
  std::uint64_t reopened = 0;
  // Bit i: the messages of source i are not sent, because a sensor is simulated and can.allow_simulated is
  // false.
  std::uint32_t withheld = 0;
};

}  // namespace slipd::can
