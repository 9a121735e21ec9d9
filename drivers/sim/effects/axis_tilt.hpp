// Taxels that do not stand upright. On a curved base each leans outwards, and none is mounted exactly. What a
// taxel calls normal and tangential is then the force turned by its tilt: pressing alone is sensed as shear
// that points outwards, and a pull is sensed as a normal force, below 0 where it is away from the taxel.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/frame/layout.hpp"

namespace slipd::sim {

struct TiltSettings {
  // Radius of the base that the taxels stand on, m; infinity: flat.
  double base_radius_m = std::numeric_limits<double>::infinity();
  // Half-width of each taxel's own tilt about each axis, rad; 0 … 0.3.
  double spread_rad = 0;
};

class AxisTilt {
 public:
  AxisTilt(const TiltSettings& settings, const TaxelLayout& layout, std::uint64_t seed);

  // Turns the true values of all taxels into what they sense; the spans have the layout's size.
  void apply(std::span<float> normal, std::span<float> shear_x, std::span<float> shear_y) const noexcept;

 private:
  // Rows: where the taxel's own x, y and normal axis point, in the sensor's frame.
  using Axes = std::array<std::array<float, 3>, 3>;
  std::vector<Axes> axes_;
};

}  // namespace slipd::sim
