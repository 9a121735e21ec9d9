// A simulated gripper and its controller: fingers that follow a set-point with a delay and a limited slew
// rate, and a set-point that follows slipd's CAN messages. Called from one thread, which provides the time.
#pragma once

#include <chrono>
#include <deque>

#include "tests/support/gripper/margin_receiver.hpp"

namespace slipd::gripper {

struct GripperSettings {
  double force_n = 2;                   // initial normal force, and the least while the margin is unknown, N
  double most_n = 40;                   // largest force, which does not crush the object, N
  std::chrono::milliseconds delay{20};  // from set-point to the first change of force
  double slew_n_per_s = 40;             // largest change of force, N/s
};

class Fingers {
 public:
  Fingers(const GripperSettings& settings, Time start) : settings_(settings), moved_(start) {}

  void want(double force_n, Time now);
  double wanted_n() const noexcept { return orders_.empty() ? goal_n_ : orders_.back().force_n; }
  double force_n(Time now);  // advances to `now`

 private:
  struct Order {
    Time at;
    double force_n;
  };
  void move(Time until);

  GripperSettings settings_;
  std::deque<Order> orders_;  // set-points within the delay
  double goal_n_ = 0, force_n_ = 0;
  Time moved_;
};

// Increases the force by an alert's GripIncrease, or by a tenth where that is unknown. It never reduces the
// force, because the right time for that depends on the task.
class Controller {
 public:
  Controller(const GripperSettings& settings, Time start) : settings_(settings), fingers_(settings, start) {
    fingers_.want(settings.force_n, start);
  }

  // The force at `now`, with what was received until then.
  double step(MarginReceiver& receiver, Time now);

 private:
  GripperSettings settings_;
  Fingers fingers_;
};

}  // namespace slipd::gripper
