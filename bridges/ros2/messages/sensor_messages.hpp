// From what slipd says of a sensor to messages. The live bridge and the export of recordings both use it, so
// that a topic means the same in both. Any thread that may allocate.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "bridges/ros2/messages/messages.hpp"

namespace slipd::ros2 {

// ns since 1970 as ROS has it. Times outside of what its 32 bits hold are cut.
Time time_of(std::int64_t realtime_ns) noexcept;

// `/slipd/NAME/LEAF`. ROS allows letters, digits and underscores in NAME, not first a digit: other characters
// become underscores, and an underscore goes before a digit.
std::string topic_of(std::string_view prefix, std::string_view name, std::string_view leaf);

// A frame's taxels, all of one length: centres in m in the sensor's frame, pressures and tractions in Pa.
struct Taxels {
  std::span<const double> x_m, y_m;
  std::span<const float> normal_pa, shear_x_pa, shear_y_pa;
};

// Whether the estimate's forces are those of the present: it is not stale, faulty, unzeroed or of no slipd.
bool forces_hold(const SlipEstimate& estimate) noexcept;
// NaN unless the state is ok.
Float32 margin_of(const SlipEstimate& estimate) noexcept;
// The margin that holds with 95 % confidence; NaN unless forces hold.
Float32 margin_low_of(const SlipEstimate& estimate) noexcept;

// Force of the object on the sensor, and its torque about the origin of the sensor's frame, in that frame: x
// and y along the sensor's, z at right angles to them, right-handed, out of the skin. A pressed sensor has a
// negative z. Unknown components are NaN, all of them unless forces hold.
WrenchStamped wrench_of(const SlipEstimate& estimate);
// The same, summed over a frame's taxels of `area_m2`. `has_shear`: the sensor measures shear.
Wrench wrench_of(const Taxels& taxels, double area_m2, bool has_shear) noexcept;

// A point for each taxel: x, y, z (m; z is 0), normal, shear_x, shear_y (Pa). Keeps the memory that `cloud`
// has.
void fill_cloud(const Header& header, const Taxels& taxels, PointCloud2& cloud);

}  // namespace slipd::ros2
