#include "core/reading/pressure_maps/make_pressure_maps.hpp"

#include "core/reading/pressure_maps/pressure_maps.hpp"
#include "core/reading/pressure_maps/subsurface_pressure_maps.hpp"

namespace slipd {

bool reads_pressure_maps(const TaxelLayout& layout, const Skin& skin) noexcept {
  return !(skin.depth_m > 0) || SubsurfacePressureMaps::can_read(layout, skin);
}

std::unique_ptr<SlipMethod> make_pressure_maps(const TaxelLayout& layout, Range friction_expected,
                                               const Skin& skin) {
  if (skin.depth_m > 0) return std::make_unique<SubsurfacePressureMaps>(layout, friction_expected, skin);
  return std::make_unique<PressureMaps>(layout, friction_expected);
}

}  // namespace slipd
