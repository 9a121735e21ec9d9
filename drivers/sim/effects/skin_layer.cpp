#include "drivers/sim/effects/skin_layer.hpp"

#include <cmath>
#include <numbers>

namespace slipd::sim {

SkinLayer::SkinLayer(const TaxelLayout& layout, std::span<const double> x_m, std::span<const double> y_m,
                     double depth_m)
    : forces_(x_m.size()) {
  influence_.reserve(layout.size() * forces_);
  const auto f = [](double value) { return static_cast<float>(value); };
  for (std::size_t taxel = 0; taxel < layout.size(); ++taxel) {
    for (std::size_t force = 0; force < forces_; ++force) {
      const double x = layout.x_m()[taxel] - x_m[force], y = layout.y_m()[taxel] - y_m[force], d = depth_m;
      const double square = x * x + y * y + d * d;
      const double scale = 3 * d / (2 * std::numbers::pi * square * square * std::sqrt(square));
      influence_.push_back({.normal_of_normal = f(scale * d * d),
                            .normal_of_shear = f(scale * d * x),
                            .x_of_normal = f(scale * d * x),
                            .x_of_shear = f(scale * x * x),
                            .y_of_normal = f(scale * d * y),
                            .y_of_shear = f(scale * x * y)});
    }
  }
}

void SkinLayer::calibrate(double taxel_area_m2) noexcept {
  double normal = 0, shear = 0;  // sensed of 1 N by each force, N
  for (const Influence& of : influence_) {
    normal += static_cast<double>(of.normal_of_normal) * taxel_area_m2;
    shear += static_cast<double>(of.x_of_shear) * taxel_area_m2;
  }
  const auto all = static_cast<double>(forces_);
  const auto normal_gain = static_cast<float>(all / normal), shear_gain = static_cast<float>(all / shear);
  for (Influence& of : influence_) {
    of.normal_of_normal *= normal_gain;
    of.normal_of_shear *= normal_gain;
    of.x_of_normal *= shear_gain;
    of.x_of_shear *= shear_gain;
    of.y_of_normal *= shear_gain;
    of.y_of_shear *= shear_gain;
  }
}

void SkinLayer::sense(std::span<const double> normal_n, std::span<const double> shear_n,
                      std::span<float> normal_pa, std::span<float> shear_x_pa,
                      std::span<float> shear_y_pa) const noexcept {
  const Influence* of = influence_.data();
  for (std::size_t taxel = 0; taxel < normal_pa.size(); ++taxel) {
    float normal = 0, x = 0, y = 0;
    for (std::size_t force = 0; force < forces_; ++force, ++of) {
      const auto p = static_cast<float>(normal_n[force]), q = static_cast<float>(shear_n[force]);
      normal += of->normal_of_normal * p + of->normal_of_shear * q;
      x += of->x_of_normal * p + of->x_of_shear * q;
      y += of->y_of_normal * p + of->y_of_shear * q;
    }
    normal_pa[taxel] = normal;
    shear_x_pa[taxel] = x;
    shear_y_pa[taxel] = y;
  }
}

}  // namespace slipd::sim
