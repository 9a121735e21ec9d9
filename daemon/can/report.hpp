// How the CAN output fares. Written by the CAN thread, read by io.
#pragma once

#include <cstdint>
#include <string_view>

namespace slipd::can {

enum class Bus : std::uint8_t { absent, down, up, warning, passive, bus_off };

constexpr std::string_view to_string(Bus bus) noexcept {
  constexpr std::string_view kWords[] = {"absent", "down", "up", "error_warning", "error_passive", "bus_off"};
  return kWords[static_cast<std::size_t>(bus)];
}

struct Report {
  Bus bus = Bus::absent;
  int error = 0;                 // why it is absent; 0: it was not tried yet
  std::uint64_t sent = 0;        // messages that the kernel took
  std::uint64_t full = 0;        // attempts for which its queue had no room; the newest value goes later
  std::uint64_t failed = 0;      // attempts that it refused
  std::uint64_t bus_errors = 0;  // error frames of the controller
  std::uint64_t bus_offs = 0;
  std::uint64_t reopened = 0;  // times that the interface came back
  std::uint32_t withheld = 0;  // bit i: message i is of a simulated sensor, and those are not allowed
};

}  // namespace slipd::can
