#include "drivers/sim/effects/axis_tilt.hpp"

#include <cmath>

#include "core/numeric/random.hpp"

namespace slipd::sim {

AxisTilt::AxisTilt(const TiltSettings& settings, const TaxelLayout& layout, std::uint64_t seed) {
  const RandomStream draws(seed);
  axes_.reserve(layout.size());
  for (std::size_t i = 0; i < layout.size(); ++i) {
    // The way the taxel leans, and how far. A force along the sensor's normal has a part against the lean.
    const double x =
        layout.x_m()[i] / settings.base_radius_m + draws.uniform(2 * i, -1, 1) * settings.spread_rad;
    const double y =
        layout.y_m()[i] / settings.base_radius_m + draws.uniform(2 * i + 1, -1, 1) * settings.spread_rad;
    const double tilt_rad = std::hypot(x, y);
    const double ex = tilt_rad > 0 ? x / tilt_rad : 1, ey = tilt_rad > 0 ? y / tilt_rad : 0;
    const double c = std::cos(tilt_rad), s = std::sin(tilt_rad), v = 1 - c;
    const auto f = [](double value) { return static_cast<float>(value); };
    // The turn by tilt_rad about the axis across the lean; pressing counts positive, so that the normal's
    // signs are those of a force into the sensor.
    axes_.push_back({{{f(1 - v * ex * ex), f(-v * ex * ey), f(s * ex)},
                      {f(-v * ex * ey), f(1 - v * ey * ey), f(s * ey)},
                      {f(-s * ex), f(-s * ey), f(c)}}});
  }
}

void AxisTilt::apply(std::span<float> normal, std::span<float> shear_x,
                     std::span<float> shear_y) const noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const float x = shear_x[i], y = shear_y[i], n = normal[i];
    const Axes& a = axes_[i];
    shear_x[i] = a[0][0] * x + a[0][1] * y + a[0][2] * n;
    shear_y[i] = a[1][0] * x + a[1][1] * y + a[1][2] * n;
    normal[i] = a[2][0] * x + a[2][1] * y + a[2][2] * n;
  }
}

}  // namespace slipd::sim
