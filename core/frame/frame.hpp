// One reading of one tactile sensor: what an estimator sees (Frame), and the slot in which it travels
// (FrameSlot).
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

namespace slipd {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// A read-only view, valid while the slot behind it is held. All spans have the layout's size. Pascal; normal
// pressure is positive when pressed; shear is the traction on the sensor along its x and y.
struct Frame {
  std::uint64_t sequence = 0;
  std::int64_t time_ns = 0;  // CLOCK_MONOTONIC, when the sample reached the lowest layer that gives a time
  std::span<const float> normal_pa, shear_x_pa, shear_y_pa;
  bool zeroed = true;  // false: what the sensor reads without load is not known, so that no value means much
};

// What a simulated sensor knows of its own contact. NaN where it does not (a real sensor, no contact).
struct Truth {
  double gamma = kUnknown;
  double friction = kUnknown;
};

// A slot that a driver fills. The spans' memory belongs to the mailbox (or to the test) that lends the slot.
struct FrameSlot {
  std::uint64_t sequence = 0;        // strictly rising; a jump tells of frames that were lost on the way
  std::int64_t time_ns = 0;          // as in Frame
  std::int64_t device_time_ns = -1;  // the device's own clock, from an origin of its own; -1: it has none
  Truth truth;                       // beside the frame, where no estimator sees it
  std::span<float> normal_pa, shear_x_pa, shear_y_pa;
  bool zeroed = true;  // as in Frame; not the driver's to set, see SensorInfo

  Frame view() const noexcept { return {sequence, time_ns, normal_pa, shear_x_pa, shear_y_pa, zeroed}; }
};

// All of `from` into the memory of `to`, which has as many taxels. Any thread; allocates nothing.
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
