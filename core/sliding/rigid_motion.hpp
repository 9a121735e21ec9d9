// The rigid motion in the plane that is nearest to a change of a field of displacements, and what is left
// beside it: stretch of the gel (Dong, Ma, Donlon, Rodriguez: Maintaining grasps within slipping bounds by
// monitoring incipient slip, ICRA 2019). Any thread; allocates nothing.
#pragma once

#include <span>

#include "core/frame/layout.hpp"

namespace slipd {

struct RigidMotion {
  // Mean displacement along x and y, mm.
  double x_mm = 0, y_mm = 0;
  // Turn about the middle of the points, rad, positive from x to y; small.
  double turn_rad = 0;
  // Root mean squares over the points, mm: of the displacement that the turn makes, and of what is not rigid.
  double turning_mm = 0, stretch_mm = 0;

  // Length of the mean displacement, mm.
  double along_mm() const noexcept;
  // Whether points move more by the turn than along.
  bool turns() const noexcept { return turning_mm > along_mm(); }
};

// Least squares over the points whose change, mm, is finite; fewer than 3 of them: no motion. The spans have
// the layout's size.
RigidMotion rigid_motion(const TaxelLayout& layout, std::span<const float> change_x_mm,
                         std::span<const float> change_y_mm) noexcept;

}  // namespace slipd
