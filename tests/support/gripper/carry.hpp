// One object that a simulated gripper lifts and carries while its friction falls, by what slipd says on CAN
// or deaf to it, and what that cost.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/estimate/chain.hpp"
#include "drivers/sim/simulated_sensor.hpp"
#include "tests/support/gripper/gripper.hpp"

namespace slipd::gripper {

// Lifted with a margin of 0.5 to 0.65, swung by up to a fifth of its weight, and losing 10 to 30 % of its
// friction again and again, until the first grip cannot hold it any more.
struct Errand {
  sim::SensorSettings sensor;
  GripperSettings gripper;
  double lifted_s = 0, length_s = 0;
};
Errand draw_errand(std::uint64_t seed);

struct Moment {
  double time_s = 0;
  double force_n = 0;  // the fingers'
  double least_n = 0;  // that with which it would just not slip
  Truth truth;
  std::optional<double> heard;  // the margin on CAN
};

// Sums from the lift's end on.
struct Carried {
  double sliding_s = 0;
  double force_share = 0;     // mean force, over the mean of the least
  double constant_share = 0;  // the least constant force that never slips, over the same
  std::vector<Moment> moments;
};
Carried carry(const Errand& errand, const ChainSetup& setup, bool listening);

}  // namespace slipd::gripper
