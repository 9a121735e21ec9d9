#include "daemon/can/encode.hpp"

#include <algorithm>
#include <boost/crc.hpp>
#include <cmath>
#include <optional>

#include "daemon/can/signals.hpp"

namespace slipd::can {
namespace {

using Crc8J1850 = boost::crc_optimal<8, 0x1D, 0xFF, 0xFF, false, false>;

// Boost builds the table of a CRC at first use. This makes it happen at load time and not in the CAN thread.
[[maybe_unused]] const std::uint8_t kTableMade = crc8({});

// The eight bytes as one little-endian number. A signal is a range of its bits.
class Payload {
 public:
  void put(const Signal& signal, std::uint64_t count) noexcept {
    const std::uint64_t mask = (std::uint64_t{1} << signal.length) - 1;
    bits_ |= (count & mask) << signal.start;
  }

  // A value of at least the signal's offset, limited to the largest count that does not mean not available.
  void put(const Signal& signal, std::optional<double> value) noexcept {
    if (!value || std::isnan(*value)) return put(signal, kNotAvailable);
    const double counts = std::round((*value - signal.offset) / signal.scale);
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
  Crc8J1850 crc;
  crc.process_bytes(data.data(), data.size());
  return crc.checksum();
}

std::uint8_t crc8(std::uint32_t id, std::span<const std::uint8_t> data) noexcept {
  Crc8J1850 crc;
  for (int byte = 0; byte < 4; ++byte) crc.process_byte(static_cast<std::uint8_t>(id >> (8 * byte)));
  crc.process_bytes(data.data(), data.size());
  return crc.checksum();
}

Message encode_estimate(std::uint32_t id, const Estimate& estimate, bool simulated,
                        unsigned counter) noexcept {
  Payload payload;
  payload.put(estimate::kGamma, margin(estimate));
  payload.put(estimate::kFriction, estimate.friction);
  payload.put(estimate::kState, static_cast<std::uint64_t>(estimate.state));
  payload.put(estimate::kAlert, static_cast<std::uint64_t>(estimate.alert));
  payload.put(estimate::kSimulated, std::uint64_t{simulated});
  payload.put(estimate::kImplausible, std::uint64_t{is_implausible(estimate.health)});
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
  payload.put(alert::kCause, std::uint64_t{estimate.alert_cause == AlertCause::sliding});
  return payload.seal(id, counter);
}

Message encode_sliding(std::uint32_t id, const Estimate& estimate, bool simulated,
                       unsigned counter) noexcept {
  Payload payload;
  const auto for_s = estimate.sliding ? estimate.sliding_for_s : std::nullopt;
  payload.put(sliding::kSlidingFor_ms, for_s ? std::optional(*for_s * 1e3) : std::nullopt);
  constexpr double kMmPerM = 1e3;
  const auto torque_nm = estimate.torque_nm;
  payload.put(sliding::kTorque_nmm, torque_nm ? std::optional(*torque_nm * kMmPerM) : std::nullopt);
  payload.put(sliding::kSliding, estimate.sliding ? static_cast<std::uint64_t>(*estimate.sliding)
                                                  : sliding::kSlidingNotAvailable);
  payload.put(sliding::kAlert, static_cast<std::uint64_t>(estimate.alert));
  payload.put(sliding::kSimulated, std::uint64_t{simulated});
  payload.put(sliding::kSequence, estimate.sequence);
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
