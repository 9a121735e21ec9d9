// Sends a simulated gripper's force to the grip_input of driver sim, one datagram each.
#pragma once

#include <string>

namespace slipd::gripper {

class GripOutput {
 public:
  explicit GripOutput(const std::string& grip_input);  // throws std::system_error if no process listens there
  ~GripOutput();
  GripOutput(const GripOutput&) = delete;
  GripOutput& operator=(const GripOutput&) = delete;

  // Normal force, N. False: the sensor is gone.
  bool press(double force_n) const noexcept;

 private:
  int fd_;
};

}  // namespace slipd::gripper
