// Load histories on the simulated presets: the chain may say little of such sensors, but no margin that is
// far too safe, and it warns of what slides.
#include <gtest/gtest.h>

#include <cmath>

#include "lab/frames/random_grasp.hpp"
#include "lab/frames/simulated_frames.hpp"
#include "lab/grasp/drive.hpp"
#include "lab/tally/tally.hpp"

namespace lab {
namespace {

using namespace slipd;

constexpr std::size_t kGrasps = 6;
// What a pillar or a magnet is gripped with; the paper's contacts are of 1–5 N.
constexpr double kTimesForce = 2;
// Rubber overshoots, so that a move of 40 ms is a blow: moves take so much longer than those of ideal
// contacts.
constexpr double kTimesDuration = 3;

// The moves of a random grasp as a script of the simulator.
sim::SensorSettings script_of(const PresetBench& bench, const Grasp& grasp, std::uint64_t seed) {
  sim::SensorSettings settings;
  settings.preset = bench.preset;
  settings.skin = contact::body_of(bench.skin);
  settings.imperfections.seed = seed;
  const auto add = [&](double seconds) -> sim::Phase& {
    sim::Phase phase;
    phase.duration_ns = std::llround(seconds * 1e9);
    settings.cycle.push_back(phase);
    return settings.cycle.back();
  };
  sim::Phase& before = add(0.3);
  before.normal_n = sim::Ramp{0, 0};
  before.shear_n = sim::Ramp{0, 0};
  double normal_n = 0, shear_n = 0;
  for (const LoadSegment& segment : grasp.segments) {
    if (segment.move == Move::unseen) continue;  // friction that rises at constant load cannot be seen
    sim::Phase& phase = add(kTimesDuration * segment.seconds);
    const double to_n = kTimesForce * segment.normal_n;
    phase.normal_n = sim::Ramp{normal_n, to_n};
    phase.shear_n = sim::Ramp{shear_n, kTimesForce * segment.shear_n};
    phase.friction = segment.friction;
    normal_n = to_n;
    const double most_n = segment.friction * normal_n;
    shear_n = std::clamp(kTimesForce * segment.shear_n, -most_n, most_n);
    if (segment.move == Move::grip) add(1);  // the grip relaxes
  }
  return settings;
}

Scene scene_of_preset(const PresetBench& bench) {
  Scene scene = chain_of(bench, std::nullopt).scene;
  scene.objects[0].normal_n = {1, 5};
  return scene;
}

struct HistoryResult {
  Tally margins;
  std::size_t sliding_frames = 0;  // the object slides, and has for 0.3 s
  std::size_t claimed_safe = 0;    // of these, with a margin above 0.4 and no alert
};

HistoryResult play(const PresetBench& bench, const sim::SensorSettings& script) {
  SimulatedFrames frames(bench, script);
  EstimatorChain chain(chain_of(bench, std::nullopt), nullptr);
  HistoryResult result;
  double sliding_s = 0;
  drive(frames, chain, [&](const GraspSample& sample) {
    const Truth& truth = sample.at.truth;
    const Estimate& estimate = sample.estimate();
    if (std::isnan(truth.gamma)) return;
    result.margins.add(estimate, truth);
    sliding_s = truth.gamma > 0 ? 0 : sliding_s + 1 / bench.rate_hz;
    if (sliding_s < 0.3) return;
    ++result.sliding_frames;
    if (estimate.gamma.value_or(0) > 0.4 && estimate.alert == Alert::none) ++result.claimed_safe;
  });
  return result;
}

class PresetHistories : public ::testing::TestWithParam<sim::Preset> {};
INSTANTIATE_TEST_SUITE_P(, PresetHistories,
                         ::testing::Values(sim::Preset::pillars, sim::Preset::magnetic_skin),
                         [](const auto& which) {
                           return which.param == sim::Preset::pillars ? "pillars" : "magnetic_skin";
                         });

TEST_P(PresetHistories, OfRandomGraspsGiveFewMarginsThatAreFarTooSafe) {
  const PresetBench bench = bench_of(GetParam());
  Tally all;
  std::size_t sliding = 0, safe = 0;
  for (std::size_t i = 0; i < kGrasps; ++i) {
    const HistoryResult result =
        play(bench, script_of(bench, draw_grasp(scene_of_preset(bench), 1, i), i + 1));
    all.add(result.margins);
    sliding += result.sliding_frames;
    safe += result.claimed_safe;
  }
  RecordProperty("overestimated", std::to_string(all.overestimated()));
  RecordProperty("answered", std::to_string(all.answered()));
  EXPECT_GT(all.frames(), 1000) << "of contact";
  EXPECT_GT(all.answered(), 0.6) << "or few margins were judged";
  EXPECT_LT(all.overestimated(), 0.05) << "answers more than 0.2 too safe; answered " << all.answered();
  EXPECT_GT(sliding, 50U);
  EXPECT_LT(static_cast<double>(safe), 0.02 * static_cast<double>(sliding)) << "of " << sliding;
}

}  // namespace
}  // namespace lab
