// How much more of its load a grasp can carry whose fingers' places are known (docs/theory.md §1.4). The
// object is one rigid body. Where it slides, each finger's contact slides as that motion has it there, and
// friction takes at most its limit surface's share of the power. The least factor by which the load may grow,
// over all motions of the body, is that of the whole: fingers that slide early leave the rest to the others.
//
// Estimate thread; plain values, nothing allocates or throws.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/grasp/finger_pose.hpp"

namespace slipd {

// What one finger carries, on its sensor's axes.
struct FingerLoad {
  FingerPose pose;
  // The contact's centre on the sensor, m.
  double center_x_m = 0, center_y_m = 0;
  double shear_x_n = 0, shear_y_n = 0, torque_nm = 0;
  // mu P, N, and the radius of a Hertz contact, m; 0: it holds no torque.
  double limit_n = 0, radius_m = 0;
};

struct GraspLoad {
  // The load's share of what the grasp carries: 1 - Gamma; 0 without load, infinite where nothing holds it.
  double used_share = 0;
  // Of used_share by each finger's limit, negative, 1/N: of the first kMost fingers.
  static constexpr std::size_t kMost = 64;
  std::array<double, kMost> per_limit_n{};
};

// At most kMost fingers count.
GraspLoad grasp_load(std::span<const FingerLoad> fingers) noexcept;

}  // namespace slipd
