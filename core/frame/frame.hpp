// A frame is one sample of one tactile sensor. Frame is the read-only view that estimators get. FrameSlot is
// the memory that a driver fills and that travels between threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

namespace slipd {

// Marks a number that is not known. Compare with std::isnan.
inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Of SensorClass::displacement the values are no pressures: along x and y how far a point of the surface is
// from its place at rest, mm, NaN where it is not seen; and for the normal pressure, how much the picture
// around it has changed since rest, 0 to 1.

// A read-only view of a frame. Valid as long as its slot is held. All spans have the layout's size. Not
// thread-safe: belongs to the thread that holds the slot.
struct Frame {
  // The device's sequence number; see FrameSlot.
  std::uint64_t sequence = 0;
  // When the sample reached the lowest layer that gives a time; ns, CLOCK_MONOTONIC.
  std::int64_t time_ns = 0;
  // Normal pressure of each taxel, Pa; positive when pressed.
  std::span<const float> normal_pa;
  // Shear traction on each taxel along the sensor's x, Pa.
  std::span<const float> shear_x_pa;
  // Shear traction on each taxel along the sensor's y, Pa.
  std::span<const float> shear_y_pa;
  // False: the sensor's bias is not known, so that no value above can be used as a load.
  bool zeroed = true;
};

// The true state of a simulated contact. No estimator sees it.
struct Truth {
  // Safety margin, 0 to 1; NaN for a real sensor or without contact.
  double gamma = kUnknown;
  // Friction coefficient, above 0; NaN for a real sensor or without contact.
  double friction = kUnknown;
};

// A frame that a driver fills. The spans' memory belongs to the lender of the slot (a mailbox, a queue, a
// test). Not thread-safe: belongs to one thread at a time.
struct FrameSlot {
  // Strictly rising. A jump by n counts as n - 1 lost frames.
  std::uint64_t sequence = 0;
  // When the sample reached the lowest layer that gives a time; ns, CLOCK_MONOTONIC.
  std::int64_t time_ns = 0;
  // The device's own clock, ns, from an origin of the device; -1: the device has no clock.
  std::int64_t device_time_ns = -1;
  // Filled by simulated sensors only.
  Truth truth;
  // Normal pressure of each taxel, Pa; positive when pressed.
  std::span<float> normal_pa;
  // Shear traction on each taxel along the sensor's x, Pa.
  std::span<float> shear_x_pa;
  // Shear traction on each taxel along the sensor's y, Pa.
  std::span<float> shear_y_pa;
  // False: the sensor's bias is not known. Drivers leave it alone; the acquire thread sets it.
  bool zeroed = true;

  // The read-only view of this slot. Truth and device time are not part of it.
  Frame view() const noexcept { return {sequence, time_ns, normal_pa, shear_x_pa, shear_y_pa, zeroed}; }
};

// Copies all members of `from` into `to`, the taxels' values into the memory that `to` has. `to` must have as
// many taxels. Called from any thread that holds both slots. Allocates nothing.
inline void copy_frame(const FrameSlot& from, FrameSlot& to) noexcept {
  const FrameSlot memory = to;
  to = from;
  to.normal_pa = memory.normal_pa;
  to.shear_x_pa = memory.shear_x_pa;
  to.shear_y_pa = memory.shear_y_pa;
  std::copy(from.normal_pa.begin(), from.normal_pa.end(), to.normal_pa.begin());
  std::copy(from.shear_x_pa.begin(), from.shear_x_pa.end(), to.shear_x_pa.begin());
  std::copy(from.shear_y_pa.begin(), from.shear_y_pa.end(), to.shear_y_pa.begin());
}

}  // namespace slipd
