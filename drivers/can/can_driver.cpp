#include "drivers/can/can_driver.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "drivers/pacing.hpp"

namespace slipd::can {
namespace {

std::string interface_of(const SensorSetup& sensor) {
  const auto found = sensor.device.find("interface");
  if (found == sensor.device.end() || !found->is_string() || found->get<std::string>().empty() ||
      found->get<std::string>().size() > 15) {
    throw DriverError("sensor \"" + sensor.name +
                      "\": device: expected {\"interface\": \"can0\"}, the network interface of the bus");
  }
  return *found;
}

}  // namespace

CanDriver::CanDriver(const std::vector<SensorSetup>& sensors, Opener opener)
    : profile_(decode::profile_of(sensors, "can")),
      interface_(interface_of(sensors.front())),
      opener_(std::move(opener)) {
  if (profile_.sensors != 1)
    throw DriverError("profile \"" + sensors.front().profile +
                      "\": on CAN each sensor is a board; expected 1 sensor");
  std::vector<unsigned> numbers;
  for (const SensorSetup& sensor : sensors) {
    const auto board = sensor.options.value("board", 1U);
    if (std::find(numbers.begin(), numbers.end(), board) != numbers.end()) {
      throw DriverError("sensor \"" + sensor.name + "\": options: board " + std::to_string(board) +
                        " is another sensor's already");
    }
    numbers.push_back(board);
    const auto with_board_number = [&](const std::vector<decode::Message>& messages) {
      std::vector<Message> out;
      out.reserve(messages.size());
      for (const auto& message : messages)
        out.push_back({decode::with_board_number(message.id, message.board_shift, board), message.bytes});
      return out;
    };
    boards_.push_back({board, decode::Decoder(profile_, 0, board), with_board_number(profile_.start),
                       with_board_number(profile_.stop)});
  }
}

DeviceInfo CanDriver::open() {
  close();
  std::vector<std::uint32_t> ids;
  DeviceInfo info{.description = profile_.description + " on " + interface_, .serial = "", .sensors = {}};
  for (Board& board : boards_) {
    for (const auto& rule : board.decoder.rules()) ids.push_back(rule.id);
    board.decoder.reset();
    board.last_activity_ns = monotonic_ns() - profile_.keep_alive_ns;  // the first read() starts it
    info.sensors.push_back(decode::info_of(profile_, "board " + std::to_string(board.number)));
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  socket_ = opener_(interface_, ids);
  return info;
}

void CanDriver::close() noexcept {
  if (!socket_.is_open()) return;
  for (const Board& board : boards_) {
    for (const Message& message : board.stop) socket_.send(message.id, message.bytes);
  }
  socket_.close();
}

// Frames with other ids are filtered by the kernel and not seen here.
std::string CanDriver::why_no_frames() const {
  for (const Board& board : boards_) {
    std::string why = board.decoder.why_no_frames("messages");
    if (!why.empty()) return why;
  }
  return {};
}

// Never waits for room in the transmit queue: a start message that was not sent is repeated after
// keep_alive_ms.
void CanDriver::restart_silent_boards(std::int64_t now_ns) noexcept {
  for (Board& board : boards_) {
    if (now_ns - board.last_activity_ns < profile_.keep_alive_ns) continue;
    for (const Message& message : board.start) socket_.send(message.id, message.bytes);
    board.last_activity_ns = now_ns;
  }
}

ReadResult CanDriver::take(const ReceivedFrame& received, std::span<FrameSlot> slots) noexcept {
  const canfd_frame& frame = received.frame;
  if ((frame.can_id & CAN_ERR_FLAG) != 0) return {ReadStatus::corrupt, 0};
  const bool extended = (frame.can_id & CAN_EFF_FLAG) != 0;
  const std::uint32_t id = frame.can_id & (extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    const auto sensor = static_cast<std::uint16_t>(i);
    switch (boards_[i].decoder.take(id, std::span(frame.data, frame.len), received.time_ns, slots[i])) {
      case decode::Outcome::foreign:
        continue;
      case decode::Outcome::partial:
        boards_[i].last_activity_ns = received.time_ns;
        return {ReadStatus::timeout, sensor};
      case decode::Outcome::frame:
        boards_[i].last_activity_ns = received.time_ns;
        return {ReadStatus::frame, sensor};
      case decode::Outcome::dropped:
        boards_[i].last_activity_ns = received.time_ns;
        return {ReadStatus::corrupt, sensor};
    }
  }
  return {ReadStatus::timeout, 0};
}

ReadResult CanDriver::read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept {
  const std::int64_t give_up_ns = monotonic_ns() + std::chrono::nanoseconds(timeout).count();
  ReceivedFrame received;
  for (;;) {
    const std::int64_t now_ns = monotonic_ns();
    restart_silent_boards(now_ns);
    switch (socket_.receive(received, give_up_ns)) {
      case ReceiveResult::disconnected:
        return {ReadStatus::disconnected, 0};
      case ReceiveResult::timeout:
        return {ReadStatus::timeout, 0};
      case ReceiveResult::frame:
        break;
    }
    const ReadResult result = take(received, slots);
    if (result.status != ReadStatus::timeout) return result;
    if (now_ns >= give_up_ns) return {ReadStatus::timeout, 0};  // a busy bus whose packets complete no frame
  }
}

}  // namespace slipd::can
