// The checksums that devices' frames carry. Acquire thread.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/decode/profile.hpp"

namespace slipd::decode {

inline std::size_t bytes_of(Sum kind) noexcept {
  return kind == Sum::none ? 0 : kind == Sum::crc8 ? 1 : 2;
}

// crc8: polynomial 07, from 0, as in SMBus.
inline std::uint32_t checksum_of(Sum kind, std::span<const std::uint8_t> bytes) noexcept {
  std::uint32_t sum = 0;
  for (const std::uint8_t byte : bytes) {
    if (kind != Sum::crc8) {
      sum = (sum + byte) & 0xFFFFU;
      continue;
    }
    sum ^= byte;
    for (int bit = 0; bit < 8; ++bit) sum = ((sum << 1) ^ ((sum & 0x80U) != 0 ? 0x107U : 0U)) & 0xFFU;
  }
  return sum;
}

}  // namespace slipd::decode
