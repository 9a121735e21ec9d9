#include "core/chain/setup/setup.hpp"

#include "core/chain/setup/sensor_kind.hpp"

namespace slipd {

bool fits_whole_pad(const ChainSetup& setup) {
  return kind_of(setup) == SensorKind::few_taxels && setup.estimator.tracking;
}

std::string_view to_string(MethodReason reason) noexcept {
  static constexpr std::string_view kNames[] = {"configured", "auto",     "few_taxels", "skin",
                                                "forces",     "no_shear", "no_force"};
  return kNames[static_cast<std::size_t>(reason)];
}

MethodReason why_method(const ChainSetup& setup) {
  const MethodChoice wanted = setup.estimator.method;
  const SensorKind kind = kind_of(setup);
  if (kind == SensorKind::displacement) return MethodReason::no_force;
  if (kind == SensorKind::pressure_only) return MethodReason::no_shear;
  if (!has_contact_model(kind)) return MethodReason::forces;
  if (wanted == MethodChoice::fit) return MethodReason::configured;
  if (fits_whole_pad(setup)) return MethodReason::few_taxels;
  if (wanted != MethodChoice::automatic) return MethodReason::configured;
  return sensed_depth_m(setup) > 0 ? MethodReason::skin : MethodReason::automatic;
}

bool needs_model(const ChainSetup& setup) {
  const MethodChoice wanted = setup.estimator.method;
  return has_contact_model(kind_of(setup)) && !fits_whole_pad(setup) &&
         !(setup.scene.skin.depth_m > 0) &&  // no trained method corrects for it
         (wanted == MethodChoice::svd_knn || wanted == MethodChoice::registered);
}

}  // namespace slipd
