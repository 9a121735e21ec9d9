#include "core/advice/alert.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"

namespace slipd {
namespace {

constexpr std::int64_t kMs = 1'000'000;

Estimate known(double gamma, double sigma = 0) {
  Estimate made;
  made.state = State::ok;
  made.gamma = gamma;
  made.sigma = sigma;
  return made;
}

Estimate unknown(State state) {
  Estimate made;
  made.state = state;
  return made;
}

constexpr State kUnknowns[] = {State::learning, State::out_of_model, State::unzeroed, State::stale,
                               State::fault};

class AlertLogicTest : public ::testing::Test {
 protected:
  Alert after(int frames, const Estimate& each) {
    Alert level = Alert::none;
    for (int i = 0; i < frames; ++i) level = logic_.update(now_ns_ += kMs, each);
    return level;
  }

  AlertLogic logic_{{}};  // warn below 0.4, slip below 0.2, hysteresis 0.05, 2 ms
  std::int64_t now_ns_ = 0;
};

TEST_F(AlertLogicTest, RaisesOnTheFirstFrameAtWhichTheMarginHasBeenLowForLongEnough) {
  EXPECT_EQ(after(10, known(0.6)), Alert::none);
  EXPECT_EQ(after(2, known(0.3)), Alert::none);
  EXPECT_EQ(after(1, known(0.3)), Alert::warn);
  EXPECT_EQ(after(2, known(0.1)), Alert::warn);
  EXPECT_EQ(after(1, known(0.1)), Alert::slip);
}

TEST(AlertLogic, ByTheSafeMarginNeedsNoOther) {
  AlertSettings settings;
  settings.use = AlertUse::low;
  AlertLogic logic(settings);
  Estimate each = unknown(State::learning);
  each.gamma_low = 0.5;
  std::int64_t now_ns = 0;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(logic.update(now_ns += kMs, each), Alert::none);
  each.gamma_low = 0.1;
  Alert level = Alert::none;
  for (int i = 0; i < 5; ++i) level = logic.update(now_ns += kMs, each);
  EXPECT_EQ(level, Alert::slip);
  each = known(0.1);
  each.gamma_low = 0.6;
  for (int i = 0; i < 5; ++i) level = logic.update(now_ns += kMs, each);
  EXPECT_EQ(level, Alert::none);
}

TEST(AlertLogic, WhatIsSeenToSlideHasNoSafeMargin) {
  AlertLogic logic({});
  Estimate sliding = known(0.8);
  sliding.gamma_low = 0.7;
  sliding.sliding = Sliding::translation;
  logic.judge(sliding);
  EXPECT_EQ(sliding.alert, Alert::slip);
  EXPECT_EQ(sliding.gamma, 0.8) << "alerts read and do not write";
  EXPECT_EQ(sliding.gamma_low, 0.7);
}

// Compared with the definition, on random margins: at a frame at which the margin has been below a threshold
// for min_ms, the alert has at least that level, and no level rises at any other frame.
TEST_F(AlertLogicTest, ALevelRisesAtThatFrameAndAtNoOther) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> step(-0.06, 0.06);
  double gamma = 0.5;
  int below_warn = 0, below_slip = 0, raised = 0;
  Alert before = Alert::none;
  for (int i = 0; i < 20000; ++i) {
    gamma = std::clamp(gamma + step(random), 0.0, 0.8);
    const Alert level = after(1, known(gamma));
    below_warn = gamma < 0.4 ? below_warn + 1 : 0;
    below_slip = gamma < 0.2 ? below_slip + 1 : 0;
    if (below_warn > 2) {
      ASSERT_GE(level, Alert::warn) << i;
    }
    if (below_slip > 2) {
      ASSERT_EQ(level, Alert::slip) << i;
    }
    if (level > before) {
      ++raised;
      ASSERT_GT(level == Alert::slip ? below_slip : below_warn, 2) << i;
    }
    before = level;
  }
  EXPECT_GT(raised, 100);
}

TEST_F(AlertLogicTest, JitterAcrossTheThresholdRaisesNoAlert) {
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(after(1, known(i % 2 == 0 ? 0.39 : 0.41)), Alert::none);
}

TEST_F(AlertLogicTest, StaysUntilTheMarginIsClearlyBackAndStepsDownThroughWarn) {
  EXPECT_EQ(after(10, known(0.1)), Alert::slip);
  EXPECT_EQ(after(10, known(0.22)), Alert::slip) << "within the hysteresis";
  EXPECT_EQ(after(10, known(0.3)), Alert::warn);
  EXPECT_EQ(after(10, known(0.42)), Alert::warn) << "within the hysteresis";
  EXPECT_EQ(after(2, known(0.6)), Alert::warn) << "not for long enough";
  EXPECT_EQ(after(1, known(0.6)), Alert::none);
}

TEST_F(AlertLogicTest, WithoutAMarginItEndsOnceTheObjectWasSeenNotToSlideForASecond) {
  ASSERT_EQ(after(10, known(0.1)), Alert::slip);
  Estimate still = unknown(State::learning);
  still.sliding = Sliding::none;
  EXPECT_EQ(after(990, still), Alert::slip);
  EXPECT_FALSE(is_raised(after(20, still)));
  EXPECT_EQ(logic_.update(now_ns_ += kMs, still, true), Alert::none) << "its pattern is watched";
}

TEST_F(AlertLogicTest, WithoutAMarginItStandsWhileNothingShowsThatTheObjectHolds) {
  for (const std::optional<Sliding> seen :
       {std::optional<Sliding>(), std::optional(Sliding::disturbed), std::optional(Sliding::rotation)}) {
    ASSERT_EQ(after(10, known(0.1)), Alert::slip);
    Estimate each = unknown(State::learning);
    each.sliding = seen;
    EXPECT_EQ(after(5000, each), Alert::slip);
  }
  Estimate low = known(0.1);
  low.sliding = Sliding::none;
  EXPECT_EQ(after(5000, low), Alert::slip) << "the margin is still low";
}

TEST_F(AlertLogicTest, TimeWithoutSamplesShowsNothing) {
  ASSERT_EQ(after(10, known(0.1)), Alert::slip);
  Estimate still = unknown(State::learning);
  still.sliding = Sliding::none;
  now_ns_ += 10'000 * kMs;
  EXPECT_EQ(after(100, still), Alert::slip);
}

TEST_F(AlertLogicTest, SigmaLowersTheMarginThatIsCompared) {
  EXPECT_EQ(after(5, known(0.45, 0.1)), Alert::warn);
}

TEST_F(AlertLogicTest, AMarginWithoutASigmaCountsAsItIs) {
  Estimate sure = known(0.45);
  sure.sigma.reset();
  EXPECT_EQ(after(10, sure), Alert::none);
}

TEST_F(AlertLogicTest, AMarginOnItsThresholdIsNotBelowIt) {
  EXPECT_EQ(after(10, known(0.4)), Alert::none);
  EXPECT_EQ(after(10, known(0.2)), Alert::warn);
}

TEST(AlertLogic, CountsFromTimeZeroLikeFromAnyOther) {
  for (const std::int64_t start_ns : {std::int64_t{0}, 5 * kMs}) {
    AlertLogic logic{{}};
    logic.update(start_ns, known(0.1));
    logic.update(start_ns + 1000 * kMs, unknown(State::learning));
    EXPECT_EQ(logic.update(start_ns + 1001 * kMs, known(0.1)), Alert::none) << start_ns;
    EXPECT_EQ(logic.update(start_ns + 1002 * kMs, known(0.1)), Alert::slip) << start_ns;
  }
}

TEST_F(AlertLogicTest, AnUnknownMarginDoesNotChangeTheAlert) {
  for (const State state : kUnknowns) {
    logic_ = AlertLogic({});
    after(1, known(0.9));
    EXPECT_EQ(after(100, unknown(state)), Alert::none) << to_string(state);
    after(5, known(0.1));
    EXPECT_EQ(after(1000, unknown(state)), Alert::slip) << to_string(state);
    EXPECT_EQ(after(1, known(0.9)), Alert::slip) << to_string(state);
    EXPECT_EQ(after(2, known(0.9)), Alert::none) << to_string(state);
  }
}

TEST_F(AlertLogicTest, NoAlertIsUnknownOnceNothingHasWatchedForTwoTenthsOfASecond) {
  EXPECT_EQ(after(1, unknown(State::learning)), Alert::unknown) << "nothing has watched yet";
  for (const Estimate& watched : {known(0.9), unknown(State::no_contact)}) {
    EXPECT_EQ(after(1, watched), Alert::none);
    EXPECT_EQ(after(200, unknown(State::learning)), Alert::none);
    EXPECT_EQ(after(1, unknown(State::learning)), Alert::unknown);
  }
  EXPECT_EQ(after(1, known(0.9)), Alert::none);
}

TEST_F(AlertLogicTest, APatternThatWouldShowSlidesWatchesWithoutAMargin) {
  Estimate seen = unknown(State::learning);
  seen.sliding = Sliding::none;
  for (int i = 0; i < 1000; ++i) {
    seen.time_ns = now_ns_ += kMs;
    logic_.judge(seen);
    ASSERT_EQ(seen.alert, Alert::none) << i;
  }
}

TEST(Alerts, ThatWereRaisedStandWithoutFramesAndNoneBecomesUnknown) {
  EXPECT_EQ(without_frames(Alert::none), Alert::unknown);
  EXPECT_EQ(without_frames(Alert::unknown), Alert::unknown);
  EXPECT_EQ(without_frames(Alert::warn), Alert::warn);
  EXPECT_EQ(without_frames(Alert::slip), Alert::slip);
}

TEST_F(AlertLogicTest, ALowMarginRaisesTheAlertDespiteFramesWithoutAMargin) {
  Alert level = Alert::none;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(level, Alert::none);
    level = after(1, known(0.1));
    if (i < 2) after(1, unknown(State::learning));
  }
  EXPECT_EQ(level, Alert::slip);
}

TEST_F(AlertLogicTest, TimeWithoutAMarginDoesNotCountTowardsTheAlert) {
  after(2, known(0.1));
  after(1000, unknown(State::learning));
  EXPECT_EQ(after(1, known(0.6)), Alert::none);
  after(1, known(0.1));
  after(1000, unknown(State::learning));
  EXPECT_EQ(after(1, known(0.1)), Alert::none);
}

TEST_F(AlertLogicTest, WithoutContactNothingCanSlip) {
  after(5, known(0.1));
  EXPECT_EQ(after(1, unknown(State::no_contact)), Alert::none);
  EXPECT_EQ(after(2, known(0.1)), Alert::none) << "another grasp begins anew";
}

TEST(SlipForecast, GivesTheTimeToSlipOfASteadyFallAndNothingForAHold) {
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

TEST(SlipForecast, IsEmptyForAMarginThatDoesNotFall) {
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

TEST(SlipForecast, BeginsAgainAfterAnUnknownMarginOrAPause) {
  SlipForecast forecast;
  for (int i = 0; i < 50; ++i) forecast.update(i * kMs, 0.9 - 0.01 * i, 0);
  EXPECT_TRUE(forecast.update(50 * kMs, 0.4, 0));
  EXPECT_FALSE(forecast.update(51 * kMs, std::nullopt, 0));
  EXPECT_FALSE(forecast.update(52 * kMs, 0.38, 0)) << "one sample has no slope";
  for (int i = 53; i < 80; ++i) forecast.update(i * kMs, 0.9 - 0.01 * i, 0);
  EXPECT_FALSE(forecast.update(500 * kMs, 0.05, 0));
}

// The forecast after `samples` samples, `step_ns` apart, of a margin that falls by `slope` a second without
// noise.
std::optional<double> forecast_of(double slope, int samples, std::int64_t step_ns = kMs, double sigma = 0) {
  SlipForecast forecast;
  std::optional<double> last;
  for (int i = 0; i < samples; ++i)
    last = forecast.update(i * step_ns, 0.9 - slope * static_cast<double>(i * step_ns) * 1e-9, sigma);
  return last;
}

TEST(SlipForecast, NeedsTheWeightOfMoreThanTwoRecentSamples) {
  EXPECT_FALSE(forecast_of(5, 2));
  EXPECT_TRUE(forecast_of(5, 3));
  // Samples 14 ms apart weigh 1.99 together at most, and those 13 ms apart 2.09.
  EXPECT_FALSE(forecast_of(2, 100, 14 * kMs));
  EXPECT_TRUE(forecast_of(2, 100, 13 * kMs));
}

// The surest margin has a sigma of kExactShare, a tenth of which over 0.0906 s is that of a slope; see below.
TEST(SlipForecast, AFallThatTheSurestMarginDoesNotShowIsNone) {
  constexpr double kLeast = kClearSigmas * 0.1 * kExactShare / 0.0906;
  EXPECT_FALSE(forecast_of(0.97 * kLeast, 200));
  EXPECT_TRUE(forecast_of(1.03 * kLeast, 200));
}

// The scatter of margins may be smaller than their error. At least a tenth of their sigma is therefore taken
// as their scatter. The sigma of a slope over the last 20 ms, a sample each 1 ms, is that divided by 0.0906
// s.
TEST(SlipForecast, AFallThatIsSmallAgainstSigmaIsNone) {
  EXPECT_FALSE(forecast_of(3.2, 200, kMs, 1.0));
  EXPECT_TRUE(forecast_of(3.4, 200, kMs, 1.0));
}

TEST(SlipForecast, IgnoresSamplesBeforeAGap) {
  for (const bool gap : {true, false}) {  // an unknown margin, or two samples with one time
    SlipForecast forecast;
    for (int i = 0; i < 50; ++i) forecast.update(i * kMs, 0.9 - 0.01 * i, 0);
    if (gap) forecast.update(50 * kMs, std::nullopt, 0);
    EXPECT_FALSE(forecast.update((gap ? 51 : 49) * kMs, 0.41, 0));
    for (int i = 52; i < 60; ++i) EXPECT_FALSE(forecast.update(i * kMs, 0.41, 0)) << gap << i;
  }
}

TEST(SlipForecast, AMarginAtItsEndHasNoTimeLeft) {
  SlipForecast forecast;
  for (int i = 0; i < 90; ++i) forecast.update(i * kMs, 0.9 - 0.01 * i, 0);
  EXPECT_DOUBLE_EQ(forecast.update(90 * kMs, 0, 0).value(), 0);
}

TEST(GripAdvice, IsTheForceThatIsMissingForTheTarget) {
  EXPECT_DOUBLE_EQ(grip_advice(2, 0.8, 0, 0.5, 0.0, 0.5).increase_n.value(), 0.8 / 0.25 - 2);
  EXPECT_DOUBLE_EQ(grip_advice(5, 0.8, 0, 0.5, 0.0, 0.5).increase_n.value(), 0);
}

TEST(GripAdvice, IsUnknownWithoutFriction) {
  for (const auto friction : {std::optional<double>(), std::optional(0.0)}) {
    const GripAdvice advice = grip_advice(2, 0.8, 0.1, friction, 0.1, 0.5);
    EXPECT_FALSE(advice.increase_n);
    EXPECT_FALSE(advice.sigma_n);
  }
}

// Compared with the scatter of the advice when friction and shear are drawn with their sigmas, to first
// order.
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
