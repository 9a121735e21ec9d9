#include "tests/support/gripper/margin_receiver.hpp"

#include <span>
#include <utility>

#include "daemon/can/encode.hpp"
#include "daemon/can/signals.hpp"

namespace slipd::gripper {
namespace {

constexpr int kSuspectAfterSilence = 3;  // frames that may have waited in a queue while the bus was away

std::uint64_t count(const can_frame& frame, const can::Signal& signal) noexcept {
  std::uint64_t bits = 0;
  for (std::size_t i = sizeof frame.data; i-- > 0;) bits = bits << 8 | frame.data[i];
  return bits >> signal.start & ((std::uint64_t{1} << signal.length) - 1);
}

std::optional<double> number(const can_frame& frame, const can::Signal& signal) noexcept {
  const std::uint64_t counts = count(frame, signal);
  if (counts == can::kNotAvailable) return std::nullopt;
  return static_cast<double>(counts) * signal.scale;
}

}  // namespace

bool MarginReceiver::Line::good(const can_frame& frame) noexcept {
  if (frame.len != sizeof frame.data) return false;
  if (can::crc8(id, std::span(frame.data).first<7>()) != frame.data[7]) return false;
  const auto now = static_cast<unsigned>(count(frame, can::kCounter));
  return std::exchange(counter, now) != now;
}

void MarginReceiver::receive(const can_frame& frame, Time now) noexcept {
  if ((frame.can_id & (CAN_RTR_FLAG | CAN_ERR_FLAG)) != 0) return;
  const std::uint32_t id = frame.can_id & CAN_EFF_MASK;
  if (id == heartbeat_.id && heartbeat_.good(frame) && count(frame, can::heartbeat::kStopping) != 0) {
    margin_.reset();
  } else if (id == alert_.id && alert_.good(frame)) {
    if (is_raised(static_cast<Alert>(count(frame, can::alert::kAlert))))
      request_ = GripRequest{number(frame, can::alert::kGripIncrease_n)};
  } else if (id == estimate_.id && estimate_.good(frame)) {
    if (!received_ || now - *received_ > 3 * period_) to_ignore_ = kSuspectAfterSilence;
    received_ = now;
    margin_.reset();
    if (to_ignore_ > 0) {
      --to_ignore_;
    } else if (count(frame, can::estimate::kState) == static_cast<std::uint64_t>(State::ok)) {
      margin_ = number(frame, can::estimate::kGamma);
    }
  }
}

std::optional<double> MarginReceiver::margin(Time now) const noexcept {
  return received_ && now - *received_ <= 3 * period_ ? margin_ : std::nullopt;
}

std::optional<MarginReceiver::GripRequest> MarginReceiver::take_request() noexcept {
  return std::exchange(request_, std::nullopt);
}

}  // namespace slipd::gripper
