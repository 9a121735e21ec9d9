// Simulated sensors at the pace of a real device: frames are due at absolute times, come late or not at all
// when asked to, and are left out (with a jump in the sequence) when this machine cannot keep up. At speed 0
// nothing is waited for or left out: a frame is due as soon as it is asked for.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driver_api/driver.hpp"
#include "drivers/sim/grip_input.hpp"
#include "drivers/sim/options.hpp"
#include "drivers/sim/simulated_sensor.hpp"

namespace slipd::sim {

class SimDriver final : public DeviceDriver {
 public:
  // Throws DriverError for options that make no sense.
  explicit SimDriver(const std::vector<SensorSetup>& sensors);

  DeviceInfo open() override;
  ReadResult read(std::span<FrameSlot> slots, std::chrono::microseconds timeout) noexcept override;
  void close() noexcept override;
  bool paced_by_consumer() const noexcept override { return !in_real_time_; }

 private:
  struct Channel {
    SensorSetup setup;
    Options options;
    std::int64_t period_ns;
    std::optional<SimulatedSensor> sensor;
    std::unique_ptr<GripInput> grip;
    std::int64_t sampled_ns = 0;  // CLOCK_MONOTONIC of the next sample
    std::int64_t due_ns = 0;      // when it comes
  };

  static void next_due(Channel& channel) noexcept;
  static void catch_up(Channel& channel, std::int64_t now_ns) noexcept;

  std::vector<Channel> channels_;
  bool in_real_time_ = true;  // of all channels
};

}  // namespace slipd::sim
