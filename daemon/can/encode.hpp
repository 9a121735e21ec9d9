// Encodes estimates as CAN messages, which config/slipd.dbc defines. Pure functions, called from any thread.
// They do not allocate.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/estimate/estimate.hpp"

namespace slipd::can {

// Offsets of identifiers from base_id. Estimate i has base_id + i, alert i has base_id + kAlertOffset + i,
// sliding i has base_id + kSlidingOffset + i. Sensors come first, then grasps.
inline constexpr std::uint32_t kAlertOffset = 0x20, kHeartbeatOffset = 0x3F, kSlidingOffset = 0x40;
// Most sensors and grasps together.
inline constexpr std::size_t kMaxMessages = 31;

// One message with eight bytes.
struct Message {
  // 11 or 29 bits, without flags.
  std::uint32_t id = 0;
  // The payload.
  std::array<std::uint8_t, 8> data{};
};

// CRC-8 SAE J1850 of the id (4 bytes, little-endian) and `data`, or of `data` alone. Check value: 0x4B for
// "123456789".
std::uint8_t crc8(std::uint32_t id, std::span<const std::uint8_t> data) noexcept;
std::uint8_t crc8(std::span<const std::uint8_t> data) noexcept;

// Gamma is sent in state ok only. Values beyond a signal's range are limited to it; unknown and NaN are sent
// as not available. Only the low 4 bits of `counter` are sent.
Message encode_estimate(std::uint32_t id, const Estimate& estimate, bool simulated,
                        unsigned counter) noexcept;
Message encode_alert(std::uint32_t id, const Estimate& estimate, bool simulated, unsigned counter) noexcept;
Message encode_sliding(std::uint32_t id, const Estimate& estimate, bool simulated, unsigned counter) noexcept;

// What the heartbeat says.
struct Heartbeat {
  // Sensors and grasps that have messages.
  std::size_t messages = 0;
  // Since the start, s.
  std::uint64_t uptime_s = 0;
  // slipd is about to stop.
  bool stopping = false;
};
Message encode_heartbeat(std::uint32_t id, const Heartbeat& heartbeat, unsigned counter) noexcept;

}  // namespace slipd::can
