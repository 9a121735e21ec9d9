#include "core/storage/crc64.hpp"

#include <array>
#include <cstddef>

namespace slipd {
namespace {

constexpr std::array<std::uint64_t, 256> make_table() {
  constexpr std::uint64_t kReflectedPolynomial = 0xC96C5795D7870F42ULL;
  std::array<std::uint64_t, 256> table{};
  for (std::size_t byte = 0; byte < table.size(); ++byte) {
    std::uint64_t value = byte;
    for (int bit = 0; bit < 8; ++bit)
      value = (value & 1) != 0 ? (value >> 1) ^ kReflectedPolynomial : value >> 1;
    table[byte] = value;
  }
  return table;
}

constexpr auto kTable = make_table();

}  // namespace

std::uint64_t crc64(std::span<const std::uint8_t> bytes) noexcept {
  std::uint64_t crc = ~0ULL;
  for (const std::uint8_t byte : bytes) crc = kTable[(crc ^ byte) & 0xFF] ^ (crc >> 8);
  return ~crc;
}

}  // namespace slipd
