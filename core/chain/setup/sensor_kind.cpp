#include "core/chain/setup/sensor_kind.hpp"

#include <cmath>

#include "core/frame/few_taxels.hpp"

namespace slipd {

std::string_view to_string(SensorKind kind) noexcept {
  static constexpr std::string_view kNames[] = {"pressure_only", "one_force", "pillars",     "flat_pad",
                                                "few_taxels",    "array",     "displacement"};
  return kNames[static_cast<std::size_t>(kind)];
}

SensorKind kind_of(const ChainSetup& setup) noexcept {
  if (setup.sensor_class == SensorClass::displacement) return SensorKind::displacement;
  if (setup.sensor_class == SensorClass::normal) return SensorKind::pressure_only;
  if (setup.sensor_class == SensorClass::wrench || setup.layout.size() == 1) return SensorKind::one_force;
  if (setup.scene.skin.base == SkinBase::pillars) return SensorKind::pillars;
  if (std::isinf(setup.scene.skin.radius_m)) return SensorKind::flat_pad;
  return setup.layout.size() <= kFewTaxels ? SensorKind::few_taxels : SensorKind::array;
}

double sensed_depth_m(const ChainSetup& setup) noexcept {
  constexpr double kThinnest = 1.0 / 9;
  const double depth_m = setup.scene.skin.depth_m;
  return has_contact_model(kind_of(setup)) && depth_m >= kThinnest * setup.layout.side_m() ? depth_m : 0;
}

}  // namespace slipd
