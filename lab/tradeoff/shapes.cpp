#include "lab/tradeoff/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "core/contact/scene_draws.hpp"
#include "core/numeric/random.hpp"
#include "core/reading/fit/fit.hpp"
#include "core/reading/pressure_maps/make_pressure_maps.hpp"
#include "lab/tradeoff/shape_bound.hpp"

namespace lab {
namespace {

using namespace slipd;

constexpr double kShapeNoise = 0.01;
constexpr std::size_t kGuided = 200;  // contacts that the guide is the mean of

// Frames of a closing.
constexpr int kFramesOfClosing = 100;

struct ShapeCase {
  double depth_mm, axes, depth_taken, power;  // of the profile
  Method method;
  SkinBase base = SkinBase::half_space, base_taken = SkinBase::half_space;
  // Whether the method is set to the true depth and base.
  bool known() const { return depth_taken == 1 && base_taken == base; }
};
constexpr SkinBase kHalfSpace = SkinBase::half_space, kRigid = SkinBase::rigid;
constexpr ShapeCase kCases[] = {{0, 1, 1, 2, Method::fit},
                                {0.5, 1, 1, 2, Method::fit},
                                {1, 1, 1, 2, Method::fit},
                                {2, 1, 1, 2, Method::fit},
                                {0, 1.5, 1, 2, Method::fit},
                                {0, 2, 1, 2, Method::fit},
                                {0.5, 1.5, 1, 2, Method::fit},
                                {1, 2, 1, 2, Method::fit},
                                {2, 1.5, 1, 2, Method::fit},
                                {1, 1, 0.75, 2, Method::fit},
                                {1, 1, 1.25, 2, Method::fit},
                                {0.5, 1, 1, 2, Method::fit, kRigid, kRigid},
                                {1, 1, 1, 2, Method::fit, kRigid, kRigid},
                                {2, 1, 1, 2, Method::fit, kRigid, kRigid},
                                {1, 1.5, 1, 2, Method::fit, kRigid, kRigid},
                                {1, 1, 1, 2, Method::fit, kRigid, kHalfSpace},
                                {2, 1, 1, 2, Method::fit, kRigid, kHalfSpace},
                                {1, 1, 1, 2, Method::fit, kHalfSpace, kRigid},
                                {2, 1, 1, 2, Method::fit, kHalfSpace, kRigid},
                                {0, 1, 1, 2, Method::closing},
                                {0, 1.7, 1, 2, Method::closing},
                                {0, 1, 1, 6, Method::closing},
                                {0.5, 1, 1, 2, Method::closing},
                                {1, 1, 1, 2, Method::closing},
                                {1, 1.7, 1, 2, Method::closing},
                                {1, 1, 1, 6, Method::closing},
                                {2, 1, 1, 2, Method::closing},
                                {2, 1.7, 1, 2, Method::closing},
                                {2, 1, 1, 6, Method::closing},
                                {1, 1, 0.75, 2, Method::closing},
                                {1, 1, 1.25, 2, Method::closing},
                                {2, 1, 0.75, 2, Method::closing},
                                {2, 1, 1.25, 2, Method::closing}};

std::optional<double> bonded_poisson(const Scene& scene, SkinBase base) {
  Skin skin = scene.skin;
  skin.base = base;
  return skin.bonded_poisson();
}

Scene shape_scene() {
  Scene scene;
  scene.objects = paper_objects();
  scene.offset_m = 0.002;
  scene.noise = kShapeNoise;
  return scene;
}

std::unique_ptr<SlipMethod> method_of(const ShapeCase& of, const TaxelLayout& layout, const Scene& scene) {
  const double depth_m = 1e-3 * of.depth_mm * of.depth_taken;
  const Range friction = expected_friction(scene);
  if (of.method == Method::closing) return make_pressure_maps(layout, friction, {.depth_m = depth_m});
  Skin skin = scene.skin;
  skin.depth_m = depth_m;
  skin.base = of.base_taken;
  return make_fit(layout, friction, skin);
}

double guide_of(const TaxelLayout& layout, const Scene& scene, const ShapeCase& of, std::size_t contacts,
                std::uint64_t seed) {
  // Priors as methods have them: Gamma within 0 … 1 and friction within the scene's range, both even.
  const Range friction = expected_friction(scene);
  const auto bonded = bonded_poisson(scene, of.base);
  ContactShape model(layout, 1e-3 * of.depth_mm, bonded);
  contact::ContactField sheet(
      layout,
      {.depth_m = 1e-3 * of.depth_mm, .bonded_poisson = bonded, .stretch = of.axes, .power = of.power});
  double sum = 0;
  for (std::size_t i = 0; i < contacts; ++i) {
    const ContactDraw draw = draw_contact(scene, seed, i);
    const RandomStream random = RandomStream(seed ^ 0x6c696d6974ULL).stream(i);
    const double gamma = random.uniform(0, 0.001, 0.999);
    const auto pair =
        contact::make_body_pair(contact::body_of(scene.skin), {draw.radius_m, draw.modulus_pa, draw.poisson});
    const double a = pair.contact_radius_m(draw.normal_n), root = std::sqrt(of.axes);
    const KnownContact truth{.x_m = draw.x_m,
                             .y_m = draw.y_m,
                             .ellipse = {a * root, a / root, std::numbers::pi * random.uniform(1)},
                             .load = (1 - gamma) * draw.friction,
                             .gamma = gamma,
                             .pull_rad = 2 * std::numbers::pi * random.uniform(2)};
    constexpr double kDeviation = kShapeNoise / std::numbers::sqrt3;
    sheet.turn(truth.ellipse.angle_rad);
    const double alone =
        of.method == Method::closing
            ? cramer_rao_sigma_by_closing(sheet, layout.size(), pair, draw.normal_n, truth, kDeviation)
            : cramer_rao_sigma(model, truth, kDeviation);
    const double range = std::min(1.0, truth.load / friction.low) - truth.load / friction.high;
    sum += std::sqrt(2 / std::numbers::pi) / std::sqrt(1 / (alone * alone) + 12 / (range * range));
  }
  return sum / static_cast<double>(contacts);
}

}  // namespace

std::vector<ShapeLine> measure_shapes(const TradeoffOptions& options, const Tell& tell) {
  constexpr double kPad = 0.016;
  std::vector<ShapeLine> lines;
  const Scene scene = shape_scene();
  std::size_t unit = 0;
  for (const std::string& name : options.layouts) {
    if (name == "wrench" || name == "4") continue;
    const std::size_t side = std::stoul(name);
    const TaxelLayout layout = TaxelLayout::grid(side, side, kPad / static_cast<double>(side));
    for (const ShapeCase& of : kCases) {
      const std::size_t here = unit++;
      tell(static_cast<double>(here) / static_cast<double>(std::size(kCases) * options.layouts.size()),
           name.c_str());
      if (!options.shard.has(here)) continue;
      const std::unique_ptr<SlipMethod> method = method_of(of, layout, scene);
      SlipMethod* const only = method.get();
      const contact::ContactGeometry geometry{.depth_m = 1e-3 * of.depth_mm,
                                              .bonded_poisson = bonded_poisson(scene, of.base),
                                              .stretch = of.axes,
                                              .power = of.power};
      lines.push_back({name, to_string(of.method).data(), of.depth_mm, of.axes, of.power, of.depth_taken,
                       of.base, of.base_taken, std::numeric_limits<double>::quiet_NaN(),
                       measure_shape_tradeoff(layout, scene, geometry, std::span(&only, 1), NoiseKind::sensor,
                                              kShapeNoise, options.contacts, options.seed + 1,
                                              of.method == Method::closing ? kFramesOfClosing : 0)
                           .front(),
                       here});
      if (of.known())
        lines.back().guide =
            guide_of(layout, scene, of, std::min(options.contacts, kGuided), options.seed + 1);
    }
  }
  return lines;
}

void print_shapes(const std::vector<ShapeLine>& lines, std::size_t contacts) {
  std::printf(
      "Methods fit and closing under a skin and on other shapes: %zu contacts, up to 2 mm off the middle of "
      "a +-8 mm pad, Gamma uniform, 1 %% of sensor noise; closing after %d frames of the closing.\n   method "
      " "
      "taxels  depth mm  axes  r^n  depth taken        base  base taken   guide  mean err     95 %%  "
      "answered  1 "
      "sigma  2 sigma   safer   p50 us   p99 us\n",
      contacts, kFramesOfClosing);
  for (const ShapeLine& line : lines) {
    const TradeoffRow& row = line.row;
    std::printf(
        "%9s %7s %9.2g %5.2g %4g %12.2g  %10s  %10s  %6.4f   %7.4f  %7.4f   %5.1f %%  %4.1f %%   %4.1f %%  "
        "%4.1f %%  %7.1f  %7.1f\n",
        line.method.c_str(), line.layout.c_str(), line.depth_mm, line.axes, line.power, line.depth_taken,
        slipd::to_string(line.base), slipd::to_string(line.base_taken), line.guide, row.mean_error,
        row.p95_error, 100 * row.answered, 100 * row.within_sigma, 100 * row.within_two_sigma,
        100 * row.claims_safer, row.p50_us, row.p99_us);
  }
}

offline::SweepResult shapes_to_sweep(const std::vector<ShapeLine>& lines, std::size_t contacts) {
  offline::SweepResult sweep{{{"contacts", contacts}}, {}};
  for (const ShapeLine& line : lines) {
    const TradeoffRow& row = line.row;
    sweep.add_row(line.unit, {{"layout", line.layout},
                              {"method", line.method},
                              {"depth_mm", line.depth_mm},
                              {"axes", line.axes},
                              {"power", line.power},
                              {"depth_taken", line.depth_taken},
                              {"base", slipd::to_string(line.base)},
                              {"base_taken", slipd::to_string(line.base_taken)},
                              {"guide", line.guide},
                              {"mean_error", row.mean_error},
                              {"p95_error", row.p95_error},
                              {"answered", row.answered},
                              {"within_sigma", row.within_sigma},
                              {"within_two_sigma", row.within_two_sigma},
                              {"claims_safer", row.claims_safer},
                              {"p50_us", row.p50_us},
                              {"p99_us", row.p99_us}});
  }
  return sweep;
}

}  // namespace lab
