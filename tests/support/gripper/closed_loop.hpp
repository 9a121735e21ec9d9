// The closed loop of a grasp, in frame time and as fast as it can be computed: simulated
// sensor → estimator → CAN messages over a socket pair → controller → grip_input → simulated sensor. Every
// byte takes its real path; only time is simulated, so that the same seed gives the same result on any
// machine.
#pragma once

#include <vector>

#include "config/settings.hpp"
#include "core/chain/chain.hpp"
#include "daemon/can/scheduler.hpp"
#include "drivers/sim/grip_input.hpp"
#include "drivers/sim/simulated_sensor.hpp"
#include "tests/support/gripper/bus_pair.hpp"
#include "tests/support/gripper/grip_output.hpp"
#include "tests/support/gripper/gripper.hpp"
#include "tests/support/temp_folder.hpp"

namespace slipd::gripper {

class ClosedLoop {
 public:
  static constexpr std::chrono::milliseconds kFrame{1};

  // `listening` false: open loop; the gripper ignores slipd and holds with its initial force.
  ClosedLoop(const sim::SensorSettings& sensor, const GripperSettings& gripper, const ChainSetup& setup,
             bool listening);

  // Advances by one frame. Then truth(), force_n() and received() are those of that frame.
  void step();
  Truth truth() const noexcept { return sensor_.truth(); }
  double force_n() const noexcept { return force_n_; }
  std::optional<double> received() const noexcept { return receiver_.margin(now_); }

 private:
  SensorStatus& add_sensor();
  void publish(Estimate estimate) noexcept;

  testing::TempFolder folder_;
  Settings settings_;
  Board board_;
  LogRing log_;
  Time now_{std::chrono::seconds(1000)}, due_{};
  BusPair bus_;
  SensorStatus& status_;
  can::CanScheduler scheduler_;
  sim::SimulatedSensor sensor_;
  EstimatorChain chain_;
  std::vector<float> memory_;
  FrameSlot slot_;
  sim::GripInput grip_input_;
  GripOutput grip_output_;
  MarginReceiver receiver_;
  Controller controller_;
  bool listening_;
  double force_n_ = 0;
};

}  // namespace slipd::gripper
