// Where a finger holds an object, in a frame fixed to the gripper. Plain values; any thread.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace slipd {

using Vector3 = std::array<double, 3>;

inline Vector3 cross(const Vector3& a, const Vector3& b) noexcept {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double dot(const Vector3& a, const Vector3& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
// To length 1. False, and not changed: it has none.
inline bool normalise(Vector3& v) noexcept {
  const double length = std::sqrt(dot(v, v));
  if (!(length > 0) || !std::isfinite(length)) return false;
  for (double& value : v) value /= length;
  return true;
}

struct FingerPose {
  // The middle of its sensor, m.
  Vector3 at_m{};
  // Directions of the sensor's x and y axes: of length 1, at right angles. Torque is positive from x to y.
  Vector3 x{}, y{};
};

// From the sensor's normal, the direction of x times y, and its x axis; of any length above 0. What x has
// along the normal is taken off. False: they are parallel, or one is 0.
inline bool make_pose(const Vector3& at_m, const Vector3& normal, const Vector3& x,
                      FingerPose& pose) noexcept {
  // Sine of the angle between normal and x below which they count as parallel.
  constexpr double kParallel = 1e-3;
  Vector3 n = normal, along = x;
  if (!normalise(n) || !normalise(along)) return false;
  const double on_normal = dot(n, along);
  for (std::size_t i = 0; i < along.size(); ++i) along[i] -= on_normal * n[i];
  if (!(dot(along, along) > kParallel * kParallel) || !normalise(along)) return false;
  pose = {.at_m = at_m, .x = along, .y = cross(n, along)};
  return true;
}

}  // namespace slipd
