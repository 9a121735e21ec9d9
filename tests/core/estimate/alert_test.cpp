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

TEST(SlipForecast, SaysNothingOfAMarginThatDoesNotFall) {
  for (const double slope : {0.0, 1e-3, 4e-3}) {
    SlipForecast forecast;
    for (int i = 0; i < 100; ++i) EXPECT_FALSE(forecast.update(i * kMs, 0.3 + slope * i, 0)) << slope;
  }
}

TEST(SlipForecast, EndsWithTheFall) {
  SlipForecast forecast;
  int i = 0;
  for (; i < 100; ++i) forecast.update(i * kMs, 0.9 - 0.005 * i, 0);
  EXPECT_NEAR(forecast.update(i * kMs, 0.4, 0).value(), 0.4 / 5, 1e-3);
  for (; i < 400; ++i) forecast.update(i * kMs, 0.4 + 0.0005 * (i - 100), 0);
  EXPECT_FALSE(forecast.update(i * kMs, 0.55, 0));
}

TEST(SlipForecast, BeginsAnewAfterAMarginThatNobodyKnewOrAPause) {
  SlipForecast forecast;
  for (int i = 0; i < 50; ++i) forecast.update(i * kMs, 0.9 - 0.01 * i, 0);
  EXPECT_TRUE(forecast.update(50 * kMs, 0.4, 0));
  EXPECT_FALSE(forecast.update(51 * kMs, std::nullopt, 0));
  EXPECT_FALSE(forecast.update(52 * kMs, 0.38, 0)) << "one sample has no slope";
  for (int i = 53; i < 80; ++i) forecast.update(i * kMs, 0.9 - 0.01 * i, 0);
  EXPECT_FALSE(forecast.update(500 * kMs, 0.05, 0));
}

TEST(SlipForecast, AMarginAtItsEndHasNoTimeLeft) {
  SlipForecast forecast;
  for (int i = 0; i < 90; ++i) forecast.update(i * kMs, 0.9 - 0.01 * i, 0);
  EXPECT_DOUBLE_EQ(forecast.update(90 * kMs, 0, 0).value(), 0);
}

TEST(GripAdvice, IsWhatIsLackingForTheTargetAndNothingMore) {
  EXPECT_DOUBLE_EQ(grip_advice(2, 0.8, 0, 0.5, 0.0, 0.5).increase_n.value(), 0.8 / 0.25 - 2);
  EXPECT_DOUBLE_EQ(grip_advice(5, 0.8, 0, 0.5, 0.0, 0.5).increase_n.value(), 0);
}

TEST(GripAdvice, NobodyKnowsItWithoutFriction) {
  for (const auto friction : {std::optional<double>(), std::optional(0.0)}) {
    const GripAdvice advice = grip_advice(2, 0.8, 0.1, friction, 0.1, 0.5);
    EXPECT_FALSE(advice.increase_n);
    EXPECT_FALSE(advice.sigma_n);
  }
}

// Against the spread of what it says when friction and shear are drawn with their sigmas, to first order.
TEST(GripAdvice, ItsSigmaIsThatOfFrictionAndShear) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> unit(0, 1);
  constexpr double kFriction = 0.5, kFrictionSigma = 0.01, kShear = 0.8, kShearSigma = 0.008;
  constexpr int kTimes = 20000;
  double sum = 0, squares = 0;
  for (int i = 0; i < kTimes; ++i) {
    const double n = grip_advice(0, kShear + kShearSigma * unit(random), 0,
                                 kFriction + kFrictionSigma * unit(random), 0.0, 0.5)
                         .increase_n.value();
    sum += n;
    squares += n * n;
  }
  const double spread = std::sqrt(squares / kTimes - sum / kTimes * sum / kTimes);
  EXPECT_NEAR(grip_advice(2, kShear, kShearSigma, kFriction, kFrictionSigma, 0.5).sigma_n.value(), spread,
              0.03 * spread);
}

}  // namespace
}  // namespace slipd
