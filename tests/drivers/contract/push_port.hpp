// A program that pushes frames as a simulated device: one message a scan. Its cable is the connection, which
// it makes again whenever the driver has closed it.
#pragma once

#include <optional>

#include "drivers/pacing.hpp"
#include "tests/devices/port.hpp"
#include "tests/support/push_writer.hpp"

namespace slipd::test {

inline std::vector<devices::Packet> pushed_scan(const devices::ScanInput& input) {
  const Frame& frame = input.sensors[0];
  std::vector<float> values;
  for (std::size_t i = 0; i < frame.normal_pa.size(); ++i) {
    for (const float value : {frame.shear_x_pa[i], frame.shear_y_pa[i], frame.normal_pa[i]})
      values.push_back(value);
  }
  const std::vector<char> message =
      testing::PushWriter::frame(values, {.sequence = input.scan + 1, .time_ns = monotonic_ns()});
  return {{0, {message.begin(), message.end()}}};
}

inline const devices::DeviceModel& pushing_program() {
  static const devices::DeviceModel kModel{.name = "push",
                                           .summary = "a program that pushes frames of 4 x 4 taxels",
                                           .sensor_class = SensorClass::array3,
                                           .layout = TaxelLayout::grid(4, 4, 0.004),
                                           .rate_hz = 500,
                                           .scan = pushed_scan};
  return kModel;
}

class PushPort final : public devices::Port {
 public:
  explicit PushPort(std::filesystem::path path) : Port(pushing_program()), path_(std::move(path)) {}

  void watch(std::vector<pollfd>&) const override {}
  void serve() override {}
  void plug() override { start(); }
  void unplug() override {
    plugged_ = false;
    writer_.reset();
  }
  std::string place() const override { return path_.string(); }

  void send(std::span<const devices::Packet> scan) override {
    if (!writer_) connect();
    for (const devices::Packet& packet : scan) {
      if (!writer_) return;
      // A driver that is closed amid this, or does not read: the frame is lost.
      if (!writer_->send(packet.bytes.data(), packet.bytes.size(), MSG_DONTWAIT) && errno != EAGAIN)
        writer_.reset();
    }
  }

 private:
  void connect() {
    writer_.emplace(path_);
    const push_layout::Hello hello{.unit = push_layout::Unit::pascal, .taxels = 16};
    if (!writer_->is_connected() || !writer_->hello(hello)) writer_.reset();
  }

  std::filesystem::path path_;
  std::optional<testing::PushWriter> writer_;
};

}  // namespace slipd::test
