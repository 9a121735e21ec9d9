#include "core/chain/chain_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "core/chain/method_table.hpp"
#include "core/contact/hertz.hpp"
#include "core/frame/few_taxels.hpp"
#include "core/reading/fit/fit.hpp"
#include "core/reading/moments/moments.hpp"
#include "core/reading/pressure_maps/pressure_maps.hpp"

namespace slipd {
namespace {

bool flat(const ChainSetup& setup) {
  return std::isinf(setup.scene.skin.radius_m);
}

std::unique_ptr<SlipMethod> make_fit(const ChainSetup& setup, const FitOptions& options = {}) {
  return std::make_unique<Fit>(setup.layout, expected_friction(setup.scene), options,
                               setup.scene.skin.depth_m, setup.scene.skin.depth_sigma,
                               setup.scene.skin.bonded_poisson());
}

std::unique_ptr<SlipMethod> make_closing(const ChainSetup& setup) {
  if (!PressureMaps::can_read(setup.layout, setup.scene.skin))
    throw std::invalid_argument(
        "method closing under a skin with depth_mm above 0 needs a regular grid of taxels and the base "
        "half_space");
  return std::make_unique<PressureMaps>(setup.layout, expected_friction(setup.scene), setup.scene.skin);
}

// `auto`: of the methods that need no training, the one whose error on contacts of this size is least within
// the time given.
std::unique_ptr<SlipMethod> choose_method(const ChainSetup& setup, WorkPrecision& work_precision) {
  work_precision = expected_work(setup);
  const Method method = choose_for(setup, work_precision).method;
  if (method == Method::moments) return std::make_unique<Moments>(setup.layout);
  if (method == Method::closing) return make_closing(setup);
  return make_fit(setup, method == Method::block_fit ? FitOptions::in_blocks() : FitOptions{});
}

}  // namespace

bool only_forces(const ChainSetup& setup) {
  return setup.sensor_class == SensorClass::wrench || setup.layout.size() == 1 || flat(setup);
}

ChainSetup with_felt_skin(const ChainSetup& setup) {
  constexpr double kThinnest = 1.0 / 9;
  ChainSetup felt = setup;
  if (only_forces(setup) || felt.scene.skin.depth_m < kThinnest * setup.layout.side_m())
    felt.scene.skin.depth_m = 0;
  return felt;
}

bool weighed_over_time(const ChainSetup& setup) {
  return only_forces(setup) || setup.layout.size() <= kFewTaxels;
}

std::optional<PadForces> make_pad_forces(const ChainSetup& setup) {
  if (!always_fits(setup) || !(setup.scene.skin.depth_m > 0)) return std::nullopt;
  return PadForces(setup.layout, setup.scene.skin);
}

MarginFusionOptions tracker_options(const ChainSetup& setup, const PadForces* pad_forces) {
  MarginFusionOptions options;
  if (!only_forces(setup) && setup.layout.size() <= kFewTaxels)
    options.least_sigma = options.few_taxels_sigma;
  // Under a skin frames leave friction open for longer, and what they then show of it has more in common:
  // relative, 0.03 … 0.2, as least_friction_sigma; `sliplab histories --skin-mm 1 --sides 16 --methods fit`.
  constexpr double kSkinFrictionSigma = 0.1;
  if (setup.scene.skin.depth_m > 0 && !weighed_over_time(setup))
    options.least_friction_sigma = kSkinFrictionSigma;
  if (pad_forces != nullptr)
    options.least_friction_sigma = std::max(options.least_friction_sigma, pad_forces->ratio_sigma());
  return options;
}

std::unique_ptr<SlipMethod> make_method(const ChainSetup& setup,
                                        const std::shared_ptr<const TrainedModel>& model,
                                        WorkPrecision& work_precision) {
  if (only_forces(setup)) return nullptr;
  const MethodChoice wanted = setup.estimator.method;
  if (setup.scene.skin.depth_m > 0 && wanted != MethodChoice::automatic && wanted != MethodChoice::fit &&
      wanted != MethodChoice::closing && !always_fits(setup)) {
    throw std::invalid_argument(
        "a skin with depth_mm above 0 needs the estimator's method fit, closing or auto");
  }
  if (needs_model(setup) && (!model || !(model->layout() == setup.layout))) {
    throw std::invalid_argument("the estimator needs a model trained for this very layout");
  }
  if (always_fits(setup)) return make_fit(setup);
  switch (wanted) {
    case MethodChoice::automatic:
      return choose_method(setup, work_precision);
    case MethodChoice::fit:
      return make_fit(setup);
    case MethodChoice::block_fit:
      return make_fit(setup, FitOptions::in_blocks());
    case MethodChoice::closing:
      return make_closing(setup);
    case MethodChoice::moments:
      return std::make_unique<Moments>(setup.layout);
    case MethodChoice::svd_knn:
    case MethodChoice::registered:
      work_precision = model->work_precision();
      return model->make_method();
  }
  throw std::invalid_argument("there is no such estimator");
}

std::unique_ptr<SlipMethod> make_closing_beside(const ChainSetup& setup) {
  if (setup.estimator.method != MethodChoice::automatic || weighed_over_time(setup) ||
      setup.sensor_class == SensorClass::normal || !PressureMaps::can_read(setup.layout, setup.scene.skin) ||
      !choose_for(setup, expected_work(setup)).closing_beside)
    return nullptr;
  return make_closing(setup);
}

PatchOptions patch_options(const ChainSetup& setup) {
  PatchOptions options;
  options.fill_dead_taxels = !flat(setup);
  return options;
}

std::unique_ptr<PadLoadSharing> make_shared_shear(const ChainSetup& setup) {
  const std::size_t taxels = setup.layout.size();
  const bool pad = setup.sensor_class == SensorClass::array3 && flat(setup);
  const bool given_value = setup.friction && setup.friction->is_value();
  if (!pad || given_value || taxels < PadLoadSharing::kLeastTaxels || taxels > PadLoadSharing::kMostTaxels)
    return nullptr;
  return std::make_unique<PadLoadSharing>(setup.layout);
}

PlausibilityLimits plausibility_limits(const ChainSetup& setup) {
  PlausibilityLimits limits{
      .full_scale = setup.full_scale.value_or(default_full_scale(setup.sensor_class, setup.layout)),
      .flat = flat(setup)};
  if (only_forces(setup) || setup.sensor_class != SensorClass::array3) return limits;
  const auto objects = setup.scene.objects.empty() ? paper_objects() : setup.scene.objects;
  const contact::Body skin = contact::body_of(setup.scene.skin);
  const auto m3_per_n = [&](double radius_m, double modulus_pa, double poisson) {
    const contact::BodyPair pair = contact::make_body_pair(skin, {radius_m, modulus_pa, poisson});
    return std::pow(pair.contact_radius_m(1), 3);
  };
  if (setup.scene.skin.depth_m > 0) return limits;  // the pressure that is read is wider than the contact
  limits.least_m3_per_n = std::numeric_limits<double>::infinity();
  for (const ObjectFamily& family : objects) {
    const double flattest_m =
        family.flat_share > 0 ? std::numeric_limits<double>::infinity() : family.radius_m.high;
    limits.least_m3_per_n = std::min(
        limits.least_m3_per_n, m3_per_n(family.radius_m.low, family.modulus_pa.high, family.poisson.high));
    limits.greatest_m3_per_n =
        std::max(limits.greatest_m3_per_n, m3_per_n(flattest_m, family.modulus_pa.low, family.poisson.low));
  }
  return limits;
}

bool always_fits(const ChainSetup& setup) {
  return setup.sensor_class == SensorClass::array3 && !only_forces(setup) &&
         setup.layout.size() <= kFewTaxels && setup.estimator.tracking;
}

std::string_view to_string(MethodReason reason) noexcept {
  static constexpr std::string_view kNames[] = {"configured", "auto",   "few_taxels",
                                                "skin",       "forces", "no_shear"};
  return kNames[static_cast<std::size_t>(reason)];
}

MethodReason why_method(const ChainSetup& setup) {
  const MethodChoice wanted = setup.estimator.method;
  if (setup.sensor_class == SensorClass::normal) return MethodReason::no_shear;
  if (only_forces(setup)) return MethodReason::forces;
  if (wanted == MethodChoice::fit) return MethodReason::configured;
  if (always_fits(setup)) return MethodReason::few_taxels;
  if (wanted != MethodChoice::automatic) return MethodReason::configured;
  return with_felt_skin(setup).scene.skin.depth_m > 0 ? MethodReason::skin : MethodReason::automatic;
}

bool needs_model(const ChainSetup& setup) {
  return setup.sensor_class == SensorClass::array3 && !only_forces(setup) && !always_fits(setup) &&
         !(setup.scene.skin.depth_m > 0) &&  // no trained method corrects for it
         (setup.estimator.method == MethodChoice::svd_knn ||
          setup.estimator.method == MethodChoice::registered);
}

}  // namespace slipd
