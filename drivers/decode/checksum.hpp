// The checksums that devices' frames carry. Acquire thread.
#pragma once

#include <boost/crc.hpp>
#include <cstdint>
#include <numeric>
#include <span>

#include "drivers/decode/profile.hpp"

namespace slipd::decode {

inline std::size_t bytes_of(Sum kind) noexcept {
  return kind == Sum::none ? 0 : kind == Sum::crc8 ? 1 : 2;
}

using Crc8Smbus = boost::crc_optimal<8, 0x07, 0, 0, false, false>;

// Boost makes the table of a CRC when it is first used. Framer's constructor asks once, so that the acquire
// thread never makes it.
inline std::uint32_t checksum_of(Sum kind, std::span<const std::uint8_t> bytes) noexcept {
  if (kind != Sum::crc8) return std::accumulate(bytes.begin(), bytes.end(), 0U) & 0xFFFFU;
  Crc8Smbus crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

}  // namespace slipd::decode
