#include "daemon/can/encode.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "daemon/can/signals.hpp"

namespace slipd::can {
namespace {

constexpr std::array<std::uint8_t, 256> crc_table() {
  constexpr unsigned kPolynomial = 0x1D;
  std::array<std::uint8_t, 256> table{};
  for (unsigned byte = 0; byte < table.size(); ++byte) {
    unsigned rest = byte;
    for (int bit = 0; bit < 8; ++bit) rest = (rest << 1) ^ ((rest & 0x80U) != 0 ? kPolynomial : 0);
    table[byte] = static_cast<std::uint8_t>(rest);
  }
  return table;
}

constexpr auto kCrcTable = crc_table();
constexpr std::uint8_t kCrcStart = 0xFF, kCrcFinal = 0xFF;

std::uint8_t crc_over(std::uint8_t crc, std::span<const std::uint8_t> data) noexcept {
  for (const std::uint8_t byte : data) crc = kCrcTable[crc ^ byte];
  return crc;
}

// The eight bytes as one little-endian number, in which a signal is a run of bits.
class Payload {
 public:
  void put(const Signal& signal, std::uint64_t count) noexcept {
    const std::uint64_t mask = (std::uint64_t{1} << signal.length) - 1;
    bits_ |= (count & mask) << signal.start;
  }

  // A quantity of at least 0, cut to what is not the mark of one that is not available.
  void put(const Signal& signal, std::optional<double> value) noexcept {
    if (!value || std::isnan(*value)) return put(signal, kNotAvailable);
    const double counts = std::round(*value / signal.scale);
    put(signal, static_cast<std::uint64_t>(std::clamp(counts, 0.0, static_cast<double>(kNotAvailable - 1))));
  }

  Message seal(std::uint32_t id, unsigned counter) noexcept {
    put(kCounter, std::uint64_t{counter});
    Message message{.id = id, .data = {}};
    for (std::size_t i = 0; i < message.data.size(); ++i)
      message.data[i] = static_cast<std::uint8_t>(bits_ >> (8 * i));
    message.data.back() = crc8(id, std::span(message.data).first<7>());
    return message;
  }

 private:
  std::uint64_t bits_ = 0;
};

std::optional<double> margin(const Estimate& estimate) noexcept {
  if (estimate.state != State::ok || !estimate.gamma) return std::nullopt;
  return std::isnan(*estimate.gamma) ? std::nullopt : std::optional(std::clamp(*estimate.gamma, 0.0, 1.0));
}

}  // namespace

std::uint8_t crc8(std::span<const std::uint8_t> data) noexcept {
  return crc_over(kCrcStart, data) ^ kCrcFinal;
}

std::uint8_t crc8(std::uint32_t id, std::span<const std::uint8_t> data) noexcept {
  const std::array id_bytes{static_cast<std::uint8_t>(id), static_cast<std::uint8_t>(id >> 8),
                            static_cast<std::uint8_t>(id >> 16), static_cast<std::uint8_t>(id >> 24)};
  return crc_over(crc_over(kCrcStart, id_bytes), data) ^ kCrcFinal;
}

Message encode_estimate(std::uint32_t id, const Estimate& estimate, bool simulated,
                        unsigned counter) noexcept {
  Payload payload;
  payload.put(estimate::kGamma, margin(estimate));
  payload.put(estimate::kFriction, estimate.friction);
  payload.put(estimate::kState, static_cast<std::uint64_t>(estimate.state));
  payload.put(estimate::kAlert, static_cast<std::uint64_t>(estimate.alert));
  payload.put(estimate::kSimulated, std::uint64_t{simulated});
  payload.put(estimate::kSequence, estimate.sequence);
  return payload.seal(id, counter);
}

Message encode_alert(std::uint32_t id, const Estimate& estimate, bool simulated, unsigned counter) noexcept {
  Payload payload;
  const auto time_to_slip = estimate.time_to_slip_s;
  payload.put(alert::kGamma, margin(estimate));
  payload.put(alert::kGripIncrease_n, estimate.grip_increase_n);
  payload.put(alert::kTimeToSlip_ms, time_to_slip ? std::optional(*time_to_slip * 1e3) : std::nullopt);
  payload.put(alert::kAlert, static_cast<std::uint64_t>(estimate.alert));
  payload.put(alert::kSimulated, std::uint64_t{simulated});
  return payload.seal(id, counter);
}

Message encode_heartbeat(std::uint32_t id, const Heartbeat& heartbeat, unsigned counter) noexcept {
  Payload payload;
  payload.put(heartbeat::kProtocolVersion, kProtocol);
  payload.put(heartbeat::kMessages, std::uint64_t{heartbeat.messages});
  payload.put(heartbeat::kUptime_s, heartbeat.uptime_s);
  payload.put(heartbeat::kStopping, std::uint64_t{heartbeat.stopping});
  return payload.seal(id, counter);
}

}  // namespace slipd::can
