// The work-precision table over all layouts.
#include <gtest/gtest.h>

#include <cmath>

#include "lab/tradeoff/measure.hpp"
#include "lab/tradeoff/over_time.hpp"

namespace lab {
namespace {

Line line(double p50_us, double error, double answered = 1) {
  Line made{"16", {slipd::NoiseKind::sensor, 0.01}, "", {}, {0, 0}, false};
  made.row.p50_us = p50_us;
  made.row.mean_error = error;
  made.row.answered = answered;
  return made;
}

TEST(WorkPrecisionFront, HasTheRowsThatNoOtherBeatsInBothTimeAndError) {
  std::vector<Line> lines{line(5, 0.1), line(10, 0.02), line(12, 0.05), line(50, 0.001),
                          line(1, 0.0001, 0.2)};
  mark_front(lines);
  EXPECT_TRUE(lines[0].front);
  EXPECT_TRUE(lines[1].front);
  EXPECT_FALSE(lines[2].front) << "slower and further off than the second";
  EXPECT_TRUE(lines[3].front);
  EXPECT_FALSE(lines[4].front) << "silent on most contacts";
}

TEST(TradeoffTable, HasEveryMethodBesideTheLimitAndWrenchesOverTime) {
  TradeoffOptions options;
  options.layouts = {"16", "wrench"};
  options.noises = {{slipd::NoiseKind::relative, 0.01}};
  options.contacts = 40;
  options.models = false;
  double last = -1;
  const auto lines = measure_tradeoffs(options, [&](double share, const char*) {
    EXPECT_GT(share, last);
    EXPECT_LT(share, 1);
    last = share;
  });
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[0].row.method, "moments");
  EXPECT_EQ(lines[1].row.method, "fit");
  EXPECT_GT(lines[0].row.mean_error, lines[1].limit.mean_error);
  EXPECT_LT(lines[1].row.mean_error, 3 * lines[1].limit.mean_error);
  EXPECT_EQ(lines[3].when, "after it");
}

TEST(OverTime, AWrenchKnowsMoreOnceItsObjectHasSlipped) {
  slipd::Scene scene;
  scene.objects = slipd::paper_objects();
  const auto lines = measure_over_time("wrench", slipd::TaxelLayout::wrench(0.016), scene,
                                       {slipd::NoiseKind::sensor, 0.01}, 20, 3);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_GT(lines[1].row.answered, lines[0].row.answered);
  EXPECT_LT(lines[1].row.mean_error, 0.15);
  EXPECT_TRUE(std::isnan(lines[0].limit.mean_error)) << "one force vector has no shape";
}

}  // namespace
}  // namespace lab
