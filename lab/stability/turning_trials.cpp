#include "lab/stability/turning_trials.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "core/contact/scene_draws.hpp"
#include "lab/frames/torque_frames.hpp"
#include "lab/grasp/drive.hpp"
#include "tools/offline/parallel.hpp"

namespace lab {
namespace {

using namespace slipd;

constexpr double kRadPerDeg = std::numbers::pi / 180;

// Numbers of a draw.
enum TurningDraw : std::uint64_t { mix_draw, share_draw, toward_draw, sign_draw, taxels_draw };

bool all_finite(const Estimate& estimate) {
  for (const auto& value :
       {estimate.gamma, estimate.sigma, estimate.friction, estimate.friction_sigma, estimate.normal_n,
        estimate.shear_n, estimate.center_x_m, estimate.center_y_m, estimate.radius_m,
        estimate.time_to_slip_s, estimate.grip_increase_n, estimate.grip_increase_sigma_n, estimate.gamma_low,
        estimate.torque_nm, estimate.torque_sigma_nm, estimate.pull_n, estimate.turned_rad,
        estimate.turned_sigma_rad}) {
    if (value && !std::isfinite(*value)) return false;
  }
  return true;
}

bool feels_shape(TurningAxis axis) noexcept {
  return axis != TurningAxis::one_row && axis != TurningAxis::one_taxel;
}

TaxelLayout layout_of(const TrialSetup& setup, TurningAxis axis) {
  TaxelLayout whole = layout_of(setup);
  if (axis == TurningAxis::one_row) return TaxelLayout::grid(setup.side, 1, whole.side_m());
  if (axis == TurningAxis::one_taxel)
    return TaxelLayout::wrench(whole.side_m() * static_cast<double>(setup.side));
  return whole;
}

ChainSetup chain_of(const TrialSetup& setup, TurningAxis axis, MethodChoice method, double friction) {
  ChainSetup chain{.layout = layout_of(setup, axis),
                   .sensor_class = axis == TurningAxis::one_taxel ? SensorClass::wrench : SensorClass::array3,
                   .scene = scene_of(setup),
                   .estimator = {},
                   .alerts = {},
                   .friction = {}};
  chain.estimator.method = method;
  chain.estimator.tracking = !feels_shape(axis);
  if (!feels_shape(axis)) chain.friction = friction;
  return chain;
}

struct TurningCase {
  ContactDraw contact;
  MixedLoad load;
};

TurningCase draw_turning(TurningAxis axis, double place, const TrialSetup& setup, std::size_t index) {
  TurningCase drawn{.contact = draw_contact(scene_of(setup), setup.seed, index), .load = {}};
  const RandomStream random = RandomStream(setup.seed ^ 0x7475726eULL).stream(index);
  drawn.load.mix_rad = random.uniform(TurningDraw::mix_draw, 0.15, 1.3);
  drawn.load.share = random.uniform(TurningDraw::share_draw, 0.05, 1);
  drawn.load.toward_rad = random.uniform(TurningDraw::toward_draw, 0, 2 * std::numbers::pi);
  if (axis == TurningAxis::load) {
    drawn.load.share = place;
  } else if (axis == TurningAxis::friction) {
    drawn.contact.friction = place;
  } else {
    drawn.load.mix_rad = kRadPerDeg * place;
  }
  if (random.uniform(TurningDraw::sign_draw) < 0.5) drawn.load.mix_rad = -drawn.load.mix_rad;
  return drawn;
}

// The estimates of one contact that is gripped and then loaded, with the last frame's in the statistics.
void try_turning(TurningAxis axis, const TurningCase& drawn, const TrialSetup& setup, std::size_t index,
                 RobustnessRow& row) {
  constexpr std::size_t kFramesOverTime = 20;
  std::vector<EstimatorChain> chains;
  for (const auto& method : kUntrained)
    chains.emplace_back(chain_of(setup, axis, method.choice, drawn.contact.friction), nullptr);
  const TaxelLayout layout = layout_of(setup, axis);
  const RandomStream random = RandomStream(setup.seed).stream(index).stream(TurningDraw::taxels_draw);
  const std::size_t count = feels_shape(axis) ? 1 : kFramesOverTime;
  const double normal_n = drawn.contact.normal_n;
  TorqueFrames frames(drawn.contact, scene_of(setup).skin, layout, setup.noise, random,
                      {{count, normal_n, {}}, {count, normal_n, drawn.load}});
  drive(frames, chains, [&](const GraspSample& sample) {
    for (std::size_t m = 0; m < chains.size(); ++m) {
      const Estimate& estimate = sample.estimates[m];
      row.not_finite += all_finite(estimate) ? 0 : 1;
      if (sample.at.number == 2 * count) row.by_method[m].add(estimate, sample.at.truth);
    }
  });
}

}  // namespace

std::string_view name_of(TurningAxis axis) noexcept {
  static constexpr std::array<std::string_view, std::size(kTurningAxes)> kNames{
      "mixture", "load", "mu, turned", "one row", "one taxel"};
  return kNames[static_cast<std::size_t>(axis)];
}

std::vector<double> places_on(TurningAxis axis) {
  switch (axis) {
    case TurningAxis::mixture:
      return {0, 1e-9, 1e-3, 0.1, 1, 3, 6, 10, 20, 45, 70, 85, 89, 89.999, 90};
    case TurningAxis::load:
      return {1e-9, 1e-6, 1e-3, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999999};
    case TurningAxis::friction:
      return {1e-6, 1e-4, 0.01, 0.1, 1, 5};
    case TurningAxis::one_row:
    case TurningAxis::one_taxel:
      return {0, 45, 90};
  }
  return {};
}

std::vector<RobustnessRow> measure_turning(const TrialSetup& setup, const Done& done) {
  std::vector<RobustnessRow> rows;
  std::vector<TurningAxis> axes;
  for (const TurningAxis axis : kTurningAxes) {
    for (const double place : places_on(axis)) {
      rows.push_back({std::string(name_of(axis)), place, std::vector<Tally>(std::size(kUntrained))});
      axes.push_back(axis);
    }
  }
  const auto work = [&](std::size_t i) {
    for (std::size_t j = 0; j < setup.contacts; ++j)
      try_turning(axes[i], draw_turning(axes[i], rows[i].strength, setup, j), setup, j, rows[i]);
  };
  offline::for_each_index(rows.size(), setup.threads, work, done);
  return rows;
}

}  // namespace lab
