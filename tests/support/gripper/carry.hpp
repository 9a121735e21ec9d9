// Simulates a gripper that lifts and carries an object while friction falls, in closed loop with slipd's CAN
// messages or in open loop, and measures slip and force.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/chain/chain.hpp"
#include "drivers/sim/simulated_sensor.hpp"
#include "tests/support/gripper/gripper.hpp"

namespace slipd::gripper {

// One object: lifted with a margin of 0.5 to 0.65, swung by up to a fifth of its weight, while friction falls
// in steps of 10 to 30 % until the first grip cannot hold it any more. With a lever it is held that far off
// its centre of mass, and all margins are those of force and torque.
struct CarryTask {
  sim::SensorSettings sensor;
  GripperSettings gripper;
  double lifted_s = 0, length_s = 0;
};
// `lever_m`: of the object's centre of mass beside the contact, m; objects on a lever are lighter. The same
// seed draws the same task.
CarryTask draw_carry_task(std::uint64_t seed, double lever_m = 0);

struct CarrySample {
  double time_s = 0;
  double force_n = 0;  // normal force of the fingers, N
  double least_n = 0;  // the least normal force that prevents slip, N
  Truth truth;
  std::optional<double> received;  // the margin on CAN
};

// Statistics after the end of the lift.
struct CarryResult {
  double sliding_s = 0;
  double force_share = 0;     // mean force over the mean least force
  double constant_share = 0;  // the least constant force without slip over the mean least force
  std::vector<CarrySample> samples;
};
CarryResult carry(const CarryTask& task, const ChainSetup& setup, bool listening);

}  // namespace slipd::gripper
