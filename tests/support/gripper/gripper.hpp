// A simulated gripper and its controller: fingers that follow a set-point late and no faster than they can,
// and a set-point that follows what slipd says on CAN. One thread; time is the caller's.
#pragma once

#include <chrono>
#include <deque>

#include "tests/support/gripper/hearing.hpp"

namespace slipd::gripper {

struct GripperSettings {
  double force_n = 2;                   // gripped with, and held with while nobody knows the margin
  double most_n = 40;                   // the object must not be crushed
  std::chrono::milliseconds delay{20};  // from set-point to the first motion
  double slew_n_per_s = 40;
};

class Fingers {
 public:
  Fingers(const GripperSettings& settings, Time start) : settings_(settings), moved_(start) {}

  void want(double force_n, Time now);
  double wanted_n() const noexcept { return orders_.empty() ? goal_n_ : orders_.back().force_n; }
  double force_n(Time now);  // goes on to `now`

 private:
  struct Order {
    Time at;
    double force_n;
  };
  void move(Time until);

  GripperSettings settings_;
  std::deque<Order> orders_;  // on their way
  double goal_n_ = 0, force_n_ = 0;
  Time moved_;
};

// Grips harder by what an alert says is lacking, a tenth more where slipd cannot say how much. It does not
// let go: how soon one may is a matter of the task.
class Controller {
 public:
  Controller(const GripperSettings& settings, Time start) : settings_(settings), fingers_(settings, start) {
    fingers_.want(settings.force_n, start);
  }

  // The force at `now`, with what was heard until then.
  double step(Hearing& hearing, Time now);

 private:
  GripperSettings settings_;
  Fingers fingers_;
};

}  // namespace slipd::gripper
