// Numbers as devices write them. Acquire thread: no branch can fail, whatever the bytes.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace slipd::decode {

enum class NumberKind : std::uint8_t { natural, whole, real };

struct NumberType {
  NumberKind kind = NumberKind::natural;
  std::uint8_t bytes = 1;  // 1, 2 or 4; real: 4
  bool big_endian = false;
  bool operator==(const NumberType&) const = default;
};

// `at` has type.bytes bytes. A real may be NaN or infinite.
inline double read_number(const std::uint8_t* at, NumberType type) noexcept {
  std::uint32_t raw = 0;
  for (std::size_t i = 0; i < type.bytes; ++i) {
    const std::size_t place = type.big_endian ? type.bytes - 1U - i : i;
    raw |= std::uint32_t{at[i]} << (8 * place);
  }
  if (type.kind == NumberKind::real) return static_cast<double>(std::bit_cast<float>(raw));
  if (type.kind == NumberKind::natural) return raw;
  const unsigned unused = (32U - 8U * type.bytes) & 31U;      // 24, 16 or 0
  return static_cast<std::int32_t>(raw << unused) >> unused;  // C++20: arithmetic
}

}  // namespace slipd::decode
