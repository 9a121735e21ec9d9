// Numbers in bytes that others send, as profiles name their types. Drivers and slipd-feed read them. Any
// thread, also acquire; any bytes are valid input.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace slipd::wire {

enum class NumberKind : std::uint8_t {
  natural,  // unsigned integer
  whole,    // signed integer, two's complement
  real      // IEEE 754, single or double precision
};

struct NumberType {
  NumberKind kind = NumberKind::natural;
  std::uint8_t bytes = 1;   // 1, 2 or 4; real: 4 or 8; clocks and counters: also 8
  bool big_endian = false;  // false: least significant byte first
  bool operator==(const NumberType&) const = default;
};

// Of a name such as "u8", "i16be" or "f64le", which a schema has checked.
constexpr NumberType number_type(std::string_view name) noexcept {
  const auto kind = name.front() == 'u'   ? NumberKind::natural
                    : name.front() == 'i' ? NumberKind::whole
                                          : NumberKind::real;
  const std::string_view bits = name.substr(1, name.find_first_of("bl", 1) - 1);
  const auto bytes = bits == "8" ? 1 : bits == "16" ? 2 : bits == "32" ? 4 : 8;
  return {kind, static_cast<std::uint8_t>(bytes), name.ends_with("be")};
}

// The unsigned number at `at`, of `bytes` bytes, 1 to 8.
inline std::uint64_t read_bits(const std::uint8_t* at, std::size_t bytes, bool big_endian) noexcept {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    const std::size_t place = big_endian ? bytes - 1U - i : i;
    bits |= std::uint64_t{at[i]} << (8 * place);
  }
  return bits;
}

// The number at `at`, of type.bytes bytes, at most 4, or 8 of a real. A real can be NaN or infinite.
inline double read_number(const std::uint8_t* at, NumberType type) noexcept {
  const std::uint64_t bits = read_bits(at, type.bytes, type.big_endian);
  if (type.bytes == 8) return std::bit_cast<double>(bits);
  const auto raw = static_cast<std::uint32_t>(bits);
  if (type.kind == NumberKind::real) return static_cast<double>(std::bit_cast<float>(raw));
  if (type.kind == NumberKind::natural) return raw;
  const unsigned unused = (32U - 8U * type.bytes) & 31U;      // 24, 16 or 0
  return static_cast<std::int32_t>(raw << unused) >> unused;  // C++20: arithmetic
}

// From `before` to `now`, the shorter way round: both count in `bytes` bytes, 1 to 8, and wrap. Negative:
// back.
constexpr std::int64_t steps(std::uint64_t before, std::uint64_t now, std::size_t bytes) noexcept {
  const std::size_t unused = 64U - 8U * bytes;
  return static_cast<std::int64_t>((now - before) << unused) >> unused;  // C++20: arithmetic
}

}  // namespace slipd::wire
