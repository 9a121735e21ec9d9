// The checksums of devices' frames. Acquire thread.
#pragma once

#include <boost/crc.hpp>
#include <cstdint>
#include <numeric>
#include <span>

#include "drivers/decode/profile.hpp"

namespace slipd::decode {

inline std::size_t bytes_of(ChecksumKind kind) noexcept {
  return kind == ChecksumKind::none ? 0 : kind == ChecksumKind::crc8 ? 1 : 2;
}

using Crc8Smbus = boost::crc_optimal<8, 0x07, 0, 0, false, false>;

// Boost computes the table of a CRC at its first use. Framer's constructor uses it once, so that the acquire
// thread never computes the table.
inline std::uint32_t checksum_of(ChecksumKind kind, std::span<const std::uint8_t> bytes) noexcept {
  if (kind != ChecksumKind::crc8) return std::accumulate(bytes.begin(), bytes.end(), 0U) & 0xFFFFU;
  Crc8Smbus crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

}  // namespace slipd::decode
