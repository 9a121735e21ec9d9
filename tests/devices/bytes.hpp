// Packets of simulated devices, and the encoding of numbers in them.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <vector>

namespace slipd::devices {

using Bytes = std::vector<std::uint8_t>;

// A unit of transmission: a CAN frame, a bulk transfer, a HID report, a run of registers (two bytes each,
// big-endian).
struct Packet {
  std::uint32_t address = 0;  // CAN id, endpoint, report id or first register
  Bytes bytes;
  bool operator==(const Packet&) const = default;
};

template <std::integral T>
void put_le(Bytes& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    out.push_back(static_cast<std::uint8_t>(static_cast<std::make_unsigned_t<T>>(value) >> (8 * i)));
  }
}

template <std::integral T>
void put_be(Bytes& out, T value) {
  for (std::size_t i = sizeof(T); i-- > 0;) {
    out.push_back(static_cast<std::uint8_t>(static_cast<std::make_unsigned_t<T>>(value) >> (8 * i)));
  }
}

inline void put_le(Bytes& out, float value) {
  put_le(out, std::bit_cast<std::uint32_t>(value));
}

inline void append(Bytes& out, const Bytes& more) {
  out.insert(out.end(), more.begin(), more.end());
}

// The nearest value of T; values beyond its range saturate, as an AD converter does.
template <std::integral T>
T saturated(double value) {
  constexpr double low = std::numeric_limits<T>::min(), high = std::numeric_limits<T>::max();
  return static_cast<T>(std::clamp(std::round(value), low, high));
}

}  // namespace slipd::devices
