#include "core/estimate/alert.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slipd {
namespace {

constexpr std::int64_t kMs = 1'000'000;

TEST(AlertLogic, RaisesOnTheFirstFrameAtWhichTheMarginHasBeenLowForLongEnough) {
  AlertLogic logic({});  // warn below 0.4, slip below 0.2, 2 ms
  EXPECT_EQ(logic.update(0 * kMs, 0.6, 0), Alert::none);
  EXPECT_EQ(logic.update(1 * kMs, 0.3, 0), Alert::none);
  EXPECT_EQ(logic.update(2 * kMs, 0.3, 0), Alert::none);
  EXPECT_EQ(logic.update(3 * kMs, 0.3, 0), Alert::warn);
  EXPECT_EQ(logic.update(4 * kMs, 0.1, 0), Alert::warn);
  EXPECT_EQ(logic.update(6 * kMs, 0.1, 0), Alert::slip);
}

TEST(AlertLogic, AMarginThatJitterCrossesRaisesNothing) {
  AlertLogic logic({});
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(logic.update(i * kMs, i % 2 == 0 ? 0.39 : 0.41, 0), Alert::none);
}

TEST(AlertLogic, StaysUntilTheMarginIsClearlyBackAndStepsDownThroughWarn) {
  AlertLogic logic({});
  std::int64_t t = 0;
  const auto hold = [&](double gamma) {
    Alert level = Alert::none;
    for (int i = 0; i < 10; ++i) level = logic.update(t += kMs, gamma, 0);
    return level;
  };
  EXPECT_EQ(hold(0.1), Alert::slip);
  EXPECT_EQ(hold(0.22), Alert::slip) << "within the hysteresis";
  EXPECT_EQ(hold(0.3), Alert::warn);
  EXPECT_EQ(hold(0.42), Alert::warn) << "within the hysteresis";
  EXPECT_EQ(hold(0.6), Alert::none);
}

TEST(AlertLogic, UncertaintyCountsAgainstTheGrip) {
  AlertLogic logic({});
  Alert level = Alert::none;
  for (int i = 0; i < 5; ++i) level = logic.update(i * kMs, 0.45, 0.1);
  EXPECT_EQ(level, Alert::warn);
}

TEST(AlertLogic, AnUnknownMarginIsNoAlert) {
  AlertLogic logic({});
  for (int i = 0; i < 5; ++i) logic.update(i * kMs, 0.1, 0);
  EXPECT_EQ(logic.update(6 * kMs, std::nullopt, 0), Alert::none);
}

TEST(SlipForecast, TellsTheTimeToSlipOfASteadyFallAndNothingOfAHold) {
  std::mt19937_64 random(41);
  std::normal_distribution<double> noise(0, 0.005);
  SlipForecast falling, holding;
  std::optional<double> last;
  int alarms = 0;
  for (int i = 0; i < 150; ++i) {
    const double gamma = 0.8 - 0.004 * i;  // 4 per second
    last = falling.update(i * kMs, gamma + noise(random), 0.005);
    if (holding.update(i * kMs, 0.5 + noise(random), 0.005)) ++alarms;
    if (i > 60) {
      ASSERT_TRUE(last.has_value());
      EXPECT_NEAR(*last, gamma / 4, 0.25 * gamma / 4 + 0.01);
    }
  }
  EXPECT_LT(alarms, 3);
}

TEST(GripIncrease, IsWhatIsLackingForTheTargetAndNothingMore) {
  EXPECT_DOUBLE_EQ(*grip_increase_n(2, 0.8, 0.5, 0.5), 0.8 / 0.25 - 2);
  EXPECT_DOUBLE_EQ(*grip_increase_n(5, 0.8, 0.5, 0.5), 0);
  EXPECT_FALSE(grip_increase_n(2, 0.8, std::nullopt, 0.5).has_value());
}

}  // namespace
}  // namespace slipd
