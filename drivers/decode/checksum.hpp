// The checksums of devices' frames. Acquire thread.
#pragma once

#include <boost/crc.hpp>
#include <cstdint>
#include <functional>
#include <numeric>
#include <optional>
#include <span>

#include "drivers/decode/profile.hpp"

namespace slipd::decode {

inline std::size_t bytes_of(ChecksumKind kind) noexcept {
  switch (kind) {
    case ChecksumKind::none:
      return 0;
    case ChecksumKind::sum8:
    case ChecksumKind::xor8:
    case ChecksumKind::lrc8:
    case ChecksumKind::crc8:
      return 1;
    default:
      return 2;
  }
}

// Offsets from a frame's beginning.
struct ChecksumPlace {
  std::size_t at = 0, from = 0, to = 0;
};

// Nothing where the checksum or what it covers does not lie in a frame of so many bytes.
inline std::optional<ChecksumPlace> place_of(const Checksum& sum, std::size_t frame_bytes) noexcept {
  const auto place = [frame_bytes](std::ptrdiff_t at) {
    return at < 0 ? frame_bytes - static_cast<std::size_t>(-at) : static_cast<std::size_t>(at);
  };
  const ChecksumPlace out{place(sum.at), place(sum.from), sum.to == 0 ? frame_bytes : place(sum.to)};
  if (out.at > frame_bytes || bytes_of(sum.kind) > frame_bytes - out.at) return std::nullopt;
  if (out.from > out.to || out.to > frame_bytes) return std::nullopt;
  return out;
}

inline bool is_big_endian(ChecksumKind kind) noexcept {
  return kind == ChecksumKind::sum16be || kind == ChecksumKind::crc16xmodem;
}

using Crc8Smbus = boost::crc_optimal<8, 0x07, 0, 0, false, false>;
using Crc16Modbus = boost::crc_optimal<16, 0x8005, 0xFFFF, 0, true, true>;

template <class Crc>
std::uint32_t crc_of(std::span<const std::uint8_t> bytes) noexcept {
  Crc crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

// Boost computes the table of a CRC at its first use. Framer's constructor uses it once, so that the acquire
// thread never computes the table.
inline std::uint32_t checksum_of(ChecksumKind kind, std::span<const std::uint8_t> bytes) noexcept {
  const std::uint32_t sum = std::accumulate(bytes.begin(), bytes.end(), 0U);
  switch (kind) {
    case ChecksumKind::none:
      return 0;
    case ChecksumKind::sum8:
      return sum & 0xFFU;
    case ChecksumKind::lrc8:
      return -sum & 0xFFU;
    case ChecksumKind::xor8:
      return std::accumulate(bytes.begin(), bytes.end(), 0U, std::bit_xor());
    case ChecksumKind::sum16le:
    case ChecksumKind::sum16be:
      return sum & 0xFFFFU;
    case ChecksumKind::crc8:
      return crc_of<Crc8Smbus>(bytes);
    case ChecksumKind::crc16modbus:
      return crc_of<Crc16Modbus>(bytes);
    case ChecksumKind::crc16xmodem:
      return crc_of<boost::crc_xmodem_t>(bytes);
  }
  return 0;
}

}  // namespace slipd::decode
