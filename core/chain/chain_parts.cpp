#include "core/chain/chain_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/chain/setup/method_table.hpp"
#include "core/chain/setup/sensor_kind.hpp"
#include "core/contact/hertz.hpp"
#include "core/margin/margin_over_time.hpp"
#include "core/reading/fit/fit.hpp"
#include "core/reading/moments/moments.hpp"
#include "core/reading/pressure_maps/make_pressure_maps.hpp"
#include "core/reading/pressure_maps/maps_beside_method.hpp"

namespace slipd {
namespace {

// Nothing is known of how pressure is spread over the taxels.
bool is_flat(const ChainSetup& setup) {
  return std::isinf(setup.scene.skin.radius_m) || kind_of(setup) == SensorKind::pillars;
}

bool has_skin(const ChainSetup& setup) {
  return setup.scene.skin.depth_m > 0;
}

std::unique_ptr<SlipMethod> make_fit(const ChainSetup& setup, const FitOptions& options = {}) {
  return make_fit(setup.layout, known_friction(setup).range, setup.scene.skin, options);
}

std::unique_ptr<SlipMethod> make_closing(const ChainSetup& setup) {
  return make_pressure_maps(setup.layout, known_friction(setup).range, setup.scene.skin);
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

ChainSetup with_sensed_skin(const ChainSetup& setup) {
  ChainSetup sensed = setup;
  sensed.scene.skin.depth_m = sensed_depth_m(setup);
  return sensed;
}

KnownFriction known_friction(const ChainSetup& setup) {
  return setup.friction.value_or(expected_friction(setup.scene));
}

std::unique_ptr<SurfaceForces> make_surface_forces(const ChainSetup& setup) {
  if (!has_skin(setup)) return std::make_unique<ForcesAtSurface>();
  if (fits_whole_pad(setup)) return std::make_unique<ForcesOfPad>(setup.layout, setup.scene.skin);
  return std::make_unique<ForcesUnderSkin>();
}

std::unique_ptr<MarginSource> make_margin_source(const ChainSetup& setup, double common_sigma) {
  const Range range = known_friction(setup).range;
  if (!setup.estimator.tracking)
    return std::make_unique<SingleFrameMargin>(std::sqrt(range.low * range.high));
  // Under a skin frames leave friction open for longer, and what they then show of it has more in common:
  // relative, 0.03 … 0.2, as least_friction_sigma; `slipd-lab histories --skin-mm 1 --sides 16 --methods
  // fit`.
  constexpr double kSkinFrictionSigma = 0.1;
  MarginOverTimeOptions options;
  const FrictionKnowledge friction{.expected = expected_friction(setup.scene), .given = setup.friction};
  if (kind_of(setup) == SensorKind::pillars)
    return make_margin_of_pillars(setup.estimator.sigma_max, setup.layout, friction, options);
  const bool history = needs_history(kind_of(setup));
  if (has_skin(setup) && !history) options.least_friction_sigma = kSkinFrictionSigma;
  options.least_friction_sigma = std::max(options.least_friction_sigma, common_sigma);
  return make_margin_over_time(setup.estimator.sigma_max, friction, history, options);
}

// For `auto`, pressure maps beside the method, for frames that its contact model does not fit; `method` alone
// where maps cannot be used, and where there is no time for them. `work`: of expected_work.
std::unique_ptr<SlipMethod> with_maps_beside(const ChainSetup& setup, const WorkPrecision& work,
                                             std::unique_ptr<SlipMethod> method) {
  if (needs_history(kind_of(setup)) || !reads_pressure_maps(setup.layout, setup.scene.skin) ||
      !choose_for(setup, work).closing_beside)
    return method;
  if (has_skin(setup)) return std::make_unique<MapsUnderSkin>(std::move(method), make_closing(setup));
  return std::make_unique<MapsAtSurface>(setup.layout, std::move(method), make_closing(setup));
}

std::string why_method_cannot_read(const ChainSetup& setup) {
  const MethodChoice wanted = setup.estimator.method;
  if (!(sensed_depth_m(setup) > 0) || fits_whole_pad(setup) || wanted == MethodChoice::automatic ||
      wanted == MethodChoice::fit)
    return {};
  if (wanted != MethodChoice::closing)
    return "a skin with depth_mm above 0 needs the estimator's method fit, closing or auto";
  if (reads_pressure_maps(setup.layout, setup.scene.skin)) return {};
  return "method closing under a skin with depth_mm above 0 needs a regular grid of taxels and the base "
         "half_space; otherwise use fit or auto";
}

std::unique_ptr<SlipMethod> make_method(const ChainSetup& setup,
                                        const std::shared_ptr<const TrainedModel>& model,
                                        WorkPrecision& work_precision) {
  const MethodChoice wanted = setup.estimator.method;
  if (const std::string why = why_method_cannot_read(setup); !why.empty()) throw std::invalid_argument(why);
  if (needs_model(setup) && (!model || !(model->layout() == setup.layout))) {
    throw std::invalid_argument("the estimator needs a model trained for this very layout");
  }
  if (fits_whole_pad(setup)) return make_fit(setup);
  switch (wanted) {
    case MethodChoice::automatic: {
      std::unique_ptr<SlipMethod> method = choose_method(setup, work_precision);
      return with_maps_beside(setup, work_precision, std::move(method));
    }
    case MethodChoice::fit:
      work_precision = expected_work_of(setup, Method::fit);
      return make_fit(setup);
    case MethodChoice::block_fit:
      work_precision = expected_work_of(setup, Method::block_fit);
      return make_fit(setup, FitOptions::in_blocks());
    case MethodChoice::closing:
      work_precision = expected_work_of(setup, Method::closing);
      return make_closing(setup);
    case MethodChoice::moments:
      work_precision = expected_work_of(setup, Method::moments);
      return std::make_unique<Moments>(setup.layout);
    case MethodChoice::svd_knn:
    case MethodChoice::registered:
      work_precision = model->work_precision();
      return model->make_method();
  }
  throw std::invalid_argument("there is no such estimator");
}

PatchOptions patch_options(const ChainSetup& setup) {
  PatchOptions options;
  options.fill_dead_taxels = !is_flat(setup);
  return options;
}

PlausibilityLimits plausibility_limits(const ChainSetup& setup) {
  PlausibilityLimits limits{
      .full_scale = setup.full_scale.value_or(default_full_scale(setup.sensor_class, setup.layout)),
      .flat = is_flat(setup)};
  if (!has_contact_model(kind_of(setup))) return limits;
  const auto objects = setup.scene.objects.empty() ? paper_objects() : setup.scene.objects;
  const contact::Body skin = contact::body_of(setup.scene.skin);
  const auto m3_per_n = [&](double radius_m, double modulus_pa, double poisson) {
    const contact::BodyPair pair = contact::make_body_pair(skin, {radius_m, modulus_pa, poisson});
    return std::pow(pair.contact_radius_m(1), 3);
  };
  if (has_skin(setup)) return limits;  // the pressure that is read is wider than the contact
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

}  // namespace slipd
