#include "lab/frames/preset_grasp.hpp"

#include <cmath>
#include <limits>

#include "core/numeric/random.hpp"

namespace lab {
namespace {

using namespace slipd;

// What the scene expects, and what grasps are drawn from.
constexpr Range kFriction{0.3, 1};
constexpr Range kNormalN{2, 8};
// Before the contact, for the noise to be measured, s.
constexpr double kUnloadedS = 0.3;
// Holds are loaded to at most this share of what holds: with one slippery side the true margin is above 0.5.
constexpr double kHeldLoad = 0.4;
// Slips are loaded to this share.
constexpr double kSlidingLoad = 1.15;
// At the end of each grasp, s.
constexpr double kLastS = 0.5;

sim::Phase phase_of(double seconds) {
  sim::Phase phase;
  phase.duration_ns = std::llround(seconds * 1e9);
  return phase;
}

void add_normal(sim::SensorSettings& grasp, double seconds, double from_n, double to_n) {
  grasp.cycle.push_back(phase_of(seconds));
  grasp.cycle.back().normal_n = sim::Ramp{from_n, to_n};
}

void add_load(sim::SensorSettings& grasp, double seconds, double from, double to) {
  grasp.cycle.push_back(phase_of(seconds));
  grasp.cycle.back().load = sim::Ramp{from, to};
}

}  // namespace

PresetBench bench_of(sim::Preset preset) {
  constexpr double kFlat = std::numeric_limits<double>::infinity();
  switch (preset) {
    case sim::Preset::pillars:
      return {preset, TaxelLayout::grid(3, 3, 0.007), {kFlat, 1e6, 0.49}, 500};
    case sim::Preset::magnetic_skin:
      return {preset, TaxelLayout::grid(4, 4, 0.0047), {kFlat, 0.5e6, 0.45}, 100};
    case sim::Preset::ideal:
      break;
  }
  return {preset, TaxelLayout::grid(4, 4, 0.0047), Skin{}, 500};
}

ChainSetup chain_of(const PresetBench& bench, std::optional<double> friction) {
  ChainSetup chain{.layout = bench.layout, .scene = {}, .estimator = {}, .alerts = {}, .friction = {}};
  chain.scene.skin = bench.skin;
  chain.scene.objects = {{.normal_n = {1, 20}, .friction = kFriction}};
  if (friction) chain.friction = *friction;
  return chain;
}

sim::SensorSettings draw_preset_grasp(const PresetBench& bench, GraspKind kind, std::uint64_t seed,
                                      std::size_t index) {
  const RandomStream draws =
      RandomStream(seed ^ 0x616c6572ULL).stream(static_cast<std::uint64_t>(kind)).stream(index);
  std::uint64_t i = 0;
  const auto within = [&](double low, double high) { return draws.uniform(i++, low, high); };
  sim::SensorSettings grasp;
  grasp.preset = bench.preset;
  grasp.skin = contact::body_of(bench.skin);
  grasp.imperfections.seed = draws.bits(i++);
  grasp.imperfections.noise = bench.preset == sim::Preset::ideal ? 0.005 : 0;
  const double normal_n = within(kNormalN.low, kNormalN.high);
  const double load_s = 0.05 * std::pow(40, within(0, 1));
  add_normal(grasp, kUnloadedS, 0, 0);
  grasp.cycle.back().load = sim::Ramp{0, 0};
  grasp.cycle.back().friction = within(kFriction.low, kFriction.high);
  add_normal(grasp, within(0.05, 0.15), 0, normal_n);
  grasp.cycle.push_back(phase_of(within(0.5, 1.5)));
  if (kind == GraspKind::slip) {
    add_load(grasp, load_s, 0, kSlidingLoad);
    add_load(grasp, kLastS, kSlidingLoad, kSlidingLoad);
    return grasp;
  }
  const double load = within(0, kHeldLoad);
  add_load(grasp, load_s, 0, load);
  grasp.cycle.push_back(phase_of(kLastS));
  if (within(0, 1) < 0.5) {
    const double tighter = within(1.1, 1.6);
    add_normal(grasp, within(0.02, 0.2), normal_n, normal_n * tighter);
    grasp.cycle.push_back(phase_of(kLastS));
    add_load(grasp, load_s, load / tighter, load);
    grasp.cycle.push_back(phase_of(kLastS));
  }
  return grasp;
}

}  // namespace lab
