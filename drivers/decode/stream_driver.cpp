#include "drivers/decode/stream_driver.hpp"

#include <utility>

#include "drivers/pacing.hpp"

namespace slipd::decode {

StreamDriver::StreamDriver(Profile profile, const std::vector<SensorSetup>& sensors)
    : profile_(std::move(profile)), sensors_(profile_, sensors), framer_(profile_) {}

DeviceInfo StreamDriver::open() {
  close();
  sensors_.reset();
  framer_.reset();
  OpenedDevice opened = open_device();
  transport_ = std::move(opened.transport);
  last_activity_ns_ = monotonic_ns();
  return {.description = profile_.description + " at " + opened.place,
          .serial = opened.serial,
          .simulated = false,
          .sensors = sensors_.info()};
}

std::string StreamDriver::why_no_frames() const {
  std::string why = sensors_.why_no_frames("packets");
  if (why.empty() && transport_) why = transport_->why_no_frames(framer_.counts().garbage);
  return why;
}

// A device that was reset in the meantime needs its start messages again.
void StreamDriver::restart_if_silent(std::int64_t now_ns) noexcept {
  if (now_ns - last_activity_ns_ < profile_.keep_alive_ns) return;
  transport_->restart();
  last_activity_ns_ = now_ns;
}

// Decodes the bytes that the framer holds.
ReadResult StreamDriver::decode_held(std::span<FrameSlot> slots) noexcept {
  RawPacket packet;
  for (;;) {
    switch (framer_.next(packet)) {
      case Framer::Result::incomplete:
        return {ReadStatus::timeout, 0};
      case Framer::Result::invalid:
        sensors_.mark_packet_lost();
        return {ReadStatus::corrupt, 0};
      case Framer::Result::packet:
        break;
    }
    transport_->answered();
    const ReadResult result = sensors_.take(packet.id, packet.bytes, arrived_ns_, slots);
    if (result.status != ReadStatus::timeout) return result;
  }
}

ReadResult StreamDriver::read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept {
  const std::int64_t give_up_ns = monotonic_ns() + std::chrono::nanoseconds(timeout).count();
  if (const ReadResult ready = sensors_.next_ready(); ready.status == ReadStatus::frame) return ready;
  for (;;) {
    const ReadResult result = decode_held(slots);
    if (result.status != ReadStatus::timeout) return result;
    const std::int64_t now_ns = monotonic_ns();
    restart_if_silent(now_ns);
    ReceivedBytes received;
    switch (transport_->receive(received, give_up_ns)) {
      case ReceiveResult::disconnected:
        return {ReadStatus::disconnected, 0};
      case ReceiveResult::timeout:
        return {ReadStatus::timeout, 0};
      case ReceiveResult::transfer_error:
        return {ReadStatus::corrupt, 0};
      case ReceiveResult::bytes:
        break;
    }
    arrived_ns_ = last_activity_ns_ = received.time_ns;
    framer_.put(received.bytes);
    if (now_ns >= give_up_ns)
      return {ReadStatus::timeout, 0};  // a busy device whose packets complete no frame
  }
}

}  // namespace slipd::decode
