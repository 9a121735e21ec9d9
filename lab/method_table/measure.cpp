#include "lab/method_table/measure.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "core/contact/scene_draws.hpp"
#include "core/reading/fit/fit.hpp"
#include "core/reading/moments/moments.hpp"
#include "core/reading/pressure_maps/make_pressure_maps.hpp"
#include "paper/validation/tradeoff.hpp"

namespace lab {
namespace {

using namespace slipd;

constexpr double kNoise = 0.01;
// Frames in which the gripper closes before one is read.
constexpr int kClosingFrames = 40;

// Stiff flat objects, all pressed alike: contacts of one size.
Scene scene_of_one_size() {
  Scene scene;
  scene.noise = kNoise;
  scene.objects = {{.normal_n = {3, 3},
                    .radius_m = {0.01, 0.01},
                    .flat_share = 1,
                    .modulus_pa = {2e11, 2e11},
                    .poisson = {0.25, 0.25}}};
  return scene;
}

struct Candidate {
  Method name = Method::none;
  std::unique_ptr<SlipMethod> method;
  int closing_frames = 0;
};

std::vector<Candidate> candidates(const TaxelLayout& layout, const Scene& scene) {
  const Range friction = expected_friction(scene);
  std::vector<Candidate> out;
  if (scene.skin.depth_m > 0) {
    out.push_back({Method::fit, make_fit(layout, friction, scene.skin)});
    out.push_back({Method::closing, make_pressure_maps(layout, friction, scene.skin), kClosingFrames});
    return out;
  }
  out.push_back({Method::moments, std::make_unique<Moments>(layout)});
  if (blocks_pay(layout, scene))
    out.push_back({Method::block_fit, std::make_unique<BlockFit>(layout, friction)});
  out.push_back({Method::fit, make_fit(layout, friction)});
  return out;
}

// All contacts of all repeats.
MeasuredTableRow measure(const TaxelLayout& layout, const Scene& scene, const Candidate& candidate,
                         const MethodTableWork& work) {
  MeasuredTableRow out;
  MethodTableRow& row = out.row;
  row.method = candidate.name;
  row.p50_us = row.p99_us = std::numeric_limits<double>::infinity();
  SlipMethod* const method = candidate.method.get();
  const contact::ContactGeometry geometry{.depth_m = scene.skin.depth_m,
                                          .bonded_poisson = scene.skin.bonded_poisson()};
  std::vector<double> errors;
  for (std::size_t i = 0; i < work.repeats; ++i) {
    const TradeoffRow found =
        measure_shape_tradeoff(layout, scene, geometry, std::span(&method, 1), NoiseKind::relative, kNoise,
                               work.contacts, work.seed + i, candidate.closing_frames)
            .front();
    row.answered += found.answered / static_cast<double>(work.repeats);
    row.p50_us = std::min(row.p50_us, found.p50_us);
    row.p99_us = std::min(row.p99_us, found.p99_us);
    if (std::isfinite(found.mean_error)) errors.push_back(found.mean_error);
  }
  const auto count = static_cast<double>(errors.size());
  for (const double error : errors) row.mean_error += error / count;
  double squares = 0;
  for (const double error : errors) squares += (error - row.mean_error) * (error - row.mean_error);
  out.error_sigma = std::sqrt(squares / (count - 1) / count);
  if (errors.empty()) row.mean_error = std::numeric_limits<double>::quiet_NaN();
  return out;
}

}  // namespace

std::vector<MeasuredTableRow> measure_method_table_rows(double taxels_along_radius, bool under_skin,
                                                        const MethodTableWork& work) {
  constexpr double kTaxelsPerRadius = 4.5, kLeastTaxels = 7, kDepthPerRadius = 0.25;
  Scene scene = scene_of_one_size();
  const double radius_m = mean_contact_radius_m(scene), side_m = radius_m / taxels_along_radius;
  scene.offset_m = side_m / 2;
  if (under_skin) scene.skin.depth_m = kDepthPerRadius * radius_m;
  const auto taxels =
      static_cast<std::size_t>(std::max(kLeastTaxels, std::ceil(kTaxelsPerRadius * taxels_along_radius)));
  const TaxelLayout layout = TaxelLayout::grid(taxels, taxels, side_m);
  std::vector<MeasuredTableRow> out;
  for (const Candidate& candidate : candidates(layout, scene)) {
    out.push_back(measure(layout, scene, candidate, work));
    out.back().row.under_skin = under_skin;
    out.back().row.taxels_along_radius = taxels_along_radius;
  }
  return out;
}

}  // namespace lab
