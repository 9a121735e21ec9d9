// Any estimates on any bus: each message that goes out has its identifier and checksum, and carries a margin
// in state ok only. Input: a script of orders of one byte each, with their operands.
#include <cstring>

#include "daemon/can/scheduler.hpp"
#include "daemon/can/signals.hpp"
#include "tests/daemon/can/fake_port.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace slipd;
using namespace slipd::can;
using fuzz::demand;
using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t kBase = 0x5A0;
constexpr std::size_t kSensors = 2;

void check(const Message& message) {
  demand(message.data.back() == crc8(message.id, std::span(message.data).first<7>()));
  if (message.id == kBase + kHeartbeatOffset) return;
  if (message.id >= kBase + kSlidingOffset) {
    demand(message.id - kBase - kSlidingOffset < kSensors);
    const std::uint64_t sliding = raw(message, "Sliding");
    demand(sliding <= static_cast<std::uint64_t>(Sliding::rotation) ||
           sliding == sliding::kSlidingNotAvailable);
    return;
  }
  const bool is_alert = message.id >= kBase + kAlertOffset;
  demand((message.id - kBase - (is_alert ? kAlertOffset : 0)) < kSensors);
  if (is_alert) return;
  const std::uint64_t gamma = raw(message, "Gamma");
  demand(gamma <= 10000 || gamma == kNotAvailable);
  demand(raw(message, "State") == 0 || gamma == kNotAvailable);
}

class Script {
 public:
  Script() {
    Settings& settings = settings_;
    settings.can.emplace();
    settings.can->interface = "can7";
    settings.can->sliding = true;
    for (std::size_t i = 0; i < kSensors; ++i) {
      board_.sensors.push_back(std::make_unique<SensorStatus>("s" + std::to_string(i), "none"));
      board_.sensors.back()->link = DeviceLink::open;
    }
    scheduler_.emplace(settings_, board_, port_, log_, now_);
  }

  void run(Bytes in) {
    in_ = in;
    while (!in_.empty()) {
      order(byte());
      demand(scheduler_->step(now_) >= now_ - std::chrono::seconds(1));
      for (const Message& message : port_.sent) check(message);
      port_.sent.clear();
    }
    scheduler_->send_final(now_);
    for (const Message& message : port_.sent) check(message);
  }

 private:
  std::uint8_t byte() {
    if (in_.empty()) return 0;
    const std::uint8_t first = in_.front();
    in_ = in_.subspan(1);
    return first;
  }
  template <typename T>
  T number() {
    T value{};
    const std::size_t size = std::min(sizeof value, in_.size());
    std::memcpy(&value, in_.data(), size);
    in_ = in_.subspan(size);
    return value;
  }
  std::optional<double> maybe() {
    return (byte() & 1U) != 0 ? std::optional(number<double>()) : std::nullopt;
  }

  void order(std::uint8_t what) {
    switch (what % 8) {
      case 0:
        now_ += std::chrono::milliseconds(byte());
        break;
      case 1:
        port_.room = byte();
        break;
      case 2:
        port_.send_error = byte();
        break;
      case 3:
        port_.open_error = byte();
        break;
      case 4:
        port_.errors.push_back({number<std::uint32_t>(), number<std::array<std::uint8_t, 8>>()});
        break;
      case 5:
        board_.sensors[byte() % kSensors]->simulated = (byte() & 1U) != 0;
        break;
      default:
        publish(byte() % kSensors);
    }
  }

  void publish(std::size_t sensor) {
    Published said;
    Estimate& estimate = said.estimate;
    estimate.sequence = number<std::uint32_t>();
    estimate.published_ns = std::chrono::nanoseconds(now_.time_since_epoch()).count();
    estimate.gamma = maybe();
    estimate.friction = maybe();
    estimate.time_to_slip_s = maybe();
    estimate.grip_increase_n = maybe();
    estimate.state = static_cast<State>(byte() % 8);
    estimate.alert = static_cast<Alert>(byte() % 3);
    board_.sensors[sensor]->latest.store(said);
  }

  Bytes in_;
  CanScheduler::Time now_{std::chrono::hours(1)};
  Settings settings_;
  Board board_;
  FakePort port_;
  LogRing log_;
  std::optional<CanScheduler> scheduler_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto script = std::make_unique<Script>();
  script->run(Bytes(data, size));
  return 0;
}
