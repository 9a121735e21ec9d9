// Grasps of the simulated presets, and how their alerts are counted.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "lab/alerts/report.hpp"
#include "lab/frames/simulated_frames.hpp"

namespace lab {
namespace {

using slipd::sim::Preset;

class PresetGrasps : public testing::TestWithParam<Preset> {};
INSTANTIATE_TEST_SUITE_P(, PresetGrasps,
                         testing::Values(Preset::ideal, Preset::pillars, Preset::magnetic_skin),
                         [](const auto& which) -> std::string {
                           return which.param == Preset::pillars         ? "pillars"
                                  : which.param == Preset::magnetic_skin ? "magnetic_skin"
                                                                         : "ideal";
                         });

// The true margin over a grasp, without a chain.
std::vector<double> true_margins(const PresetBench& bench, GraspKind kind, std::size_t index) {
  SimulatedFrames frames(bench.layout, draw_preset_grasp(bench, kind, 1, index), 1000);
  std::vector<double> margins;
  while (frames.next()) {
    const double margin = frames.moment().truth.gamma;
    if (!std::isnan(margin)) margins.push_back(margin);
  }
  return margins;
}

TEST_P(PresetGrasps, HoldWithAMarginOfAHalfAndSlipInTheEnd) {
  const PresetBench bench = bench_of(GetParam());
  for (std::size_t i = 0; i < 20; ++i) {
    const auto held = true_margins(bench, GraspKind::hold, i);
    EXPECT_GE(*std::min_element(held.begin(), held.end()), 0.45) << i;
    EXPECT_GT(held.size(), 1000U);
    EXPECT_LT(true_margins(bench, GraspKind::slip, i).back(), 1e-9) << i;
  }
}

// A few, for the whole path; `slipd-lab alerts` measures a thousand.
TEST_P(PresetGrasps, RunThroughTheChainWithFrictionKnownAndNot) {
  const PresetBench bench = bench_of(GetParam());
  for (std::size_t i = 0; i < 2; ++i) {
    const AlertTrialPair slip = run_preset_grasp(bench, draw_preset_grasp(bench, GraspKind::slip, 1, i));
    ASSERT_TRUE(slip.known.gross_slip_s) << i;
    EXPECT_EQ(slip.known.gross_slip_s, slip.unknown.gross_slip_s) << "one simulation for both chains";
    EXPECT_TRUE(slip.known.first_alert_s) << i;
    EXPECT_GT(slip.known.contact_frames, 50U);
    EXPECT_LE(slip.known.answered_frames, slip.known.contact_frames);
    EXPECT_GT(static_cast<double>(slip.known.answered_frames),
              0.9 * static_cast<double>(slip.known.contact_frames));
    const AlertTrialPair hold = run_preset_grasp(bench, draw_preset_grasp(bench, GraspKind::hold, 1, i));
    EXPECT_FALSE(hold.known.gross_slip_s || hold.unknown.gross_slip_s);
    EXPECT_GE(hold.known.least_margin, 0.45);
  }
}

// An alert that costs less comes no later.
TEST_P(PresetGrasps, AreToldNoLaterWhereASlipCostsMore) {
  const PresetBench bench = bench_of(GetParam());
  const std::array costs{1.0, 5.0, 100.0};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto slips = run_preset_grasp(bench, draw_preset_grasp(bench, GraspKind::slip, 2, i), costs);
    ASSERT_EQ(slips.size(), costs.size());
    for (std::size_t c = 0; c + 1 < costs.size(); ++c) {
      ASSERT_TRUE(slips[c].unknown.first_alert_s && slips[c + 1].unknown.first_alert_s) << i;
      EXPECT_GE(*slips[c].unknown.first_alert_s, *slips[c + 1].unknown.first_alert_s) << i;
    }
    const auto alone = run_preset_grasp(bench, draw_preset_grasp(bench, GraspKind::slip, 2, i));
    EXPECT_EQ(alone.unknown.first_alert_s, slips[1].unknown.first_alert_s);
  }
}

// Pillars that are pressed least slip first.
TEST(PillarsOfUnknownFriction, WarnBeforeTheySlide) {
  const PresetBench bench = bench_of(Preset::pillars);
  int warned = 0;
  constexpr int kSlips = 8;
  for (std::size_t i = 0; i < kSlips; ++i) {
    const AlertTrial slip = run_preset_grasp(bench, draw_preset_grasp(bench, GraspKind::slip, 1, i)).unknown;
    warned += slip.first_alert_s && *slip.first_alert_s < *slip.gross_slip_s ? 1 : 0;
  }
  EXPECT_GE(warned, kSlips - 1);
}

AlertTrial slipped_at(double slip_s, std::optional<double> alert_s) {
  AlertTrial trial;
  trial.gross_slip_s = slip_s;
  trial.first_alert_s = alert_s;
  return trial;
}

TEST(AlertCounts, TellBeforeSoonLateAndMissed) {
  const PresetBench pillars = bench_of(Preset::pillars), skin = bench_of(Preset::magnetic_skin);
  const std::vector<AlertTrial> slips{slipped_at(1, 0.9), slipped_at(1, 1.02), slipped_at(1, 1.2),
                                      slipped_at(1, std::nullopt)};
  AlertTrial quiet, warned, cried;
  warned.first_alert_s = 1;
  cried.first_alert_s = cried.first_slip_s = 1;
  const AlertLine line = count_alerts(pillars, true, 5, {quiet, warned, cried}, slips);
  EXPECT_EQ(line.holds, 3U);
  EXPECT_EQ(line.holds_alerted, 2U);
  EXPECT_EQ(line.holds_slip, 1U);
  EXPECT_EQ(line.slips, 4U);
  EXPECT_EQ(line.before, 1U);
  EXPECT_EQ(line.soon, 2U);
  EXPECT_EQ(line.missed, 1U);
  EXPECT_NEAR(line.median_delay_s, 0.02, 1e-12);
  // Three frames at 100 a second are 30 ms, at 20 they are 150.
  PresetBench slow = skin;
  slow.rate_hz = 20;
  EXPECT_EQ(count_alerts(slow, false, 5, {}, {slipped_at(1, 1.14), slipped_at(1, 1.16)}).soon, 1U);
  EXPECT_NE(
      alerts_table({line}).find("| `pillars` | 500 | known | 3 | 66.7 % | 33.3 % | 4 | 25.0 % | 50.0 % |"),
      std::string::npos)
      << alerts_table({line});
  EXPECT_EQ(offline::assembled(to_sweep({line}))["rows"][0]["soon"], 2);
}

}  // namespace
}  // namespace lab
