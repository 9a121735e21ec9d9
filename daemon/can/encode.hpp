// Estimates → CAN messages, as config/slipd.dbc defines them. Pure; CAN thread, allocation-free.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/estimate/estimate.hpp"

namespace slipd::can {

// Identifiers, counted from base_id. Message i is that of sensor i; grasps come after the sensors.
inline constexpr std::uint32_t kAlertOffset = 0x20, kHeartbeatOffset = 0x3F;
inline constexpr std::size_t kMostMessages = 31;

struct Message {
  std::uint32_t id = 0;  // 11 or 29 bits, without flags
  std::array<std::uint8_t, 8> data{};
};

// CRC-8 SAE J1850 of the id (4 bytes, little-endian) and `data`. Source: SAE J1850; 0x4B for "123456789"
// alone.
std::uint8_t crc8(std::uint32_t id, std::span<const std::uint8_t> data) noexcept;
std::uint8_t crc8(std::span<const std::uint8_t> data) noexcept;

// gamma is sent in state ok only. Values beyond a signal's range are cut to it; what is unknown or NaN is
// sent as not available. `counter`: its low 4 bits.
Message encode_estimate(std::uint32_t id, const Estimate& estimate, bool simulated,
                        unsigned counter) noexcept;
Message encode_alert(std::uint32_t id, const Estimate& estimate, bool simulated, unsigned counter) noexcept;

struct Heartbeat {
  std::size_t messages = 0;
  std::uint64_t uptime_s = 0;
  bool stopping = false;
};
Message encode_heartbeat(std::uint32_t id, const Heartbeat& heartbeat, unsigned counter) noexcept;

}  // namespace slipd::can
