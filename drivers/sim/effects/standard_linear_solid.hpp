// The grip of a finger of rubber: force overshoots while the gripper closes, then relaxes. A standard linear
// solid (Zener), a spring beside a spring and a damper in a row (Wineman and Rajagopal, Mechanical Response
// of Polymers, 2000, ch. 2): under a step of strain the force starts at `stiffening` times its final value
// and falls to it as exp(-t/relaxation_s).
#pragma once

namespace slipd::sim {

struct GripSettings {
  // Force at once over force at rest for the same strain, no unit; 1: elastic, up to 10.
  double stiffening = 1;
  // Time in which the excess falls to 1/e, s; above 0.
  double relaxation_s = 0.1;
};

class StandardLinearSolid {
 public:
  explicit StandardLinearSolid(const GripSettings& settings) noexcept : settings_(settings) {}

  // The force, N, dt_s after the last call. `at_rest_n`: the force that the gripper's position gives once the
  // rubber is relaxed, N; it went in a straight line from the last call's. Never below 0: a finger that opens
  // faster than its rubber follows lets go.
  double update(double at_rest_n, double dt_s) noexcept;

 private:
  GripSettings settings_;
  double at_rest_n_ = 0;
  double excess_n_ = 0;  // of the spring in the row with the damper, per stiffening - 1
};

}  // namespace slipd::sim
