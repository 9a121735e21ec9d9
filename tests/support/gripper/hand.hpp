// Where a simulated gripper's force goes: the driver's grip_input, a datagram each time.
#pragma once

#include <string>

namespace slipd::gripper {

class Hand {
 public:
  explicit Hand(const std::string& grip_input);  // throws std::system_error if nobody listens there
  ~Hand();
  Hand(const Hand&) = delete;
  Hand& operator=(const Hand&) = delete;

  // Normal force, N. False: the sensor is gone.
  bool press(double force_n) const noexcept;

 private:
  int fd_;
};

}  // namespace slipd::gripper
