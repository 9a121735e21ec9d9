// A zero that a sensor contradicts is not used: after an exchange, after drift that nobody followed, after a
// zero that was taken under load. A contact contradicts no zero.
#include "core/zero/zero_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "core/zero/bias_estimator.hpp"
#include "tests/core/zero/raw_sensor.hpp"

namespace slipd {
namespace {

using test::RawSensor;

constexpr std::int64_t kPeriodNs = 10'000'000;
constexpr double kAwayS = 3;

TaxelLayout small_pad() {
  return TaxelLayout::grid(4, 4, 0.0047);
}
TaxelLayout large_pad() {
  return TaxelLayout::grid(24, 24, 0.0006);
}

RawSensor sensor_of(const TaxelLayout& layout, std::uint64_t seed = 1) {
  return RawSensor(layout, RawSensor::kNoisePa, kPeriodNs, seed);
}

BiasEstimator estimator_of(const TaxelLayout& layout, bool exchangeable = true) {
  return BiasEstimator(layout, {0, 0}, {}, exchangeable);
}

// The zero that a free sensor gets on request.
Bias zero_of(RawSensor& sensor) {
  BiasEstimator estimator = estimator_of(sensor.layout());
  estimator.ask(1, false);
  sensor.run(estimator, 2);
  EXPECT_EQ(estimator.report().answer, BiasResult::taken);
  return estimator.zero();
}

// All frames of `seconds`, of which none is marked as zeroed.
void expect_no_zero(BiasEstimator& estimator, RawSensor& sensor, double seconds, std::int64_t later_ns = 0) {
  for (auto frames = static_cast<int>(seconds * 1e9 / kPeriodNs); frames > 0; --frames) {
    FrameSlot slot = sensor.read();
    slot.time_ns += later_ns;
    estimator.apply(slot);
    estimator.judge();
    ASSERT_FALSE(slot.zeroed);
  }
}

TEST(ZeroCheck, AnotherSensorInTheSamePlaceHasNoZeroFromItsFirstFrameOn) {
  for (const TaxelLayout& layout : {small_pad(), large_pad(), TaxelLayout::wrench(0.02)}) {
    for (std::uint64_t seed = 2; seed < 30; ++seed) {
      RawSensor first = sensor_of(layout), second = sensor_of(layout, seed);
      BiasEstimator restarted = estimator_of(layout);
      restarted.restore(zero_of(first));
      expect_no_zero(restarted, second, 1);
      EXPECT_EQ(restarted.report().origin, BiasOrigin::command);
      EXPECT_NE(restarted.report().doubt, BiasDoubt::none);
      second.press(5, 1);
      expect_no_zero(restarted, second, 1);
    }
  }
}

TEST(ZeroCheck, ASensorThatIsExchangedWhileSlipdRunsHasNoZeroEither) {
  RawSensor first = sensor_of(small_pad()), second = sensor_of(small_pad(), 2);
  BiasEstimator estimator = estimator_of(small_pad());
  estimator.restore(zero_of(first));
  EXPECT_TRUE(first.run(estimator, 1).zeroed);
  expect_no_zero(estimator, second, 1, static_cast<std::int64_t>((kAwayS + 4) * 1e9));
}

TEST(ZeroCheck, ABaselineThatIsLowerOrHigherAllOverIsNoZeroAndNoContact) {
  for (const float off_pa : {-120e3F, -5e3F, 5e3F, 120e3F}) {
    RawSensor sensor = sensor_of(small_pad());
    BiasEstimator restarted = estimator_of(small_pad());
    restarted.restore(zero_of(sensor));
    sensor.press_everywhere(off_pa, 0);
    expect_no_zero(restarted, sensor, 2);
    EXPECT_NEAR(restarted.report().off_pa, off_pa, 5 * RawSensor::kNoisePa);
  }
}

TEST(ZeroCheck, TheSameSensorHasItsZeroAtOnceFreeAndInMidGrasp) {
  for (const TaxelLayout& layout : {small_pad(), large_pad()}) {
    for (const double normal_n : {0.0, 0.5, 3.0}) {
      RawSensor sensor = sensor_of(layout);
      BiasEstimator restarted = estimator_of(layout);
      restarted.restore(zero_of(sensor));
      if (normal_n > 0) sensor.press(normal_n, 0.3 * normal_n);
      for (int i = 0; i < 100; ++i) {
        FrameSlot slot = sensor.read();
        restarted.apply(slot);
        restarted.judge();
        ASSERT_TRUE(slot.zeroed) << normal_n << " N, frame " << i;
      }
    }
  }
}

TEST(ZeroCheck, ALoadAllOverThatIsHeldWhileTheSensorIsAwayTellsThatItIsTheSame) {
  RawSensor sensor = sensor_of(TaxelLayout::wrench(0.02));
  const Bias zero = zero_of(sensor);
  BiasEstimator first = estimator_of(sensor.layout());
  first.restore(zero);
  sensor.run(first, 1);
  sensor.press_everywhere(20e3F, 5e3F);
  sensor.run(first, 1);
  first.reopened();
  EXPECT_TRUE(sensor.run(first, 1).zeroed);

  Bias kept = zero;
  kept.last_pa = first.last_reading();
  ASSERT_FALSE(kept.last_pa.empty());
  BiasEstimator second = estimator_of(sensor.layout());
  second.restore(kept);
  EXPECT_TRUE(sensor.run(second, 1).zeroed);

  BiasEstimator without = estimator_of(sensor.layout());
  without.restore(zero);
  expect_no_zero(without, sensor, 1);
  sensor.release();
  EXPECT_TRUE(sensor.run(without, 1).zeroed) << "once it is let go of";
}

TEST(ZeroCheck, ADriftWithinTheNoiseIsNoReasonForDoubt) {
  RawSensor sensor = sensor_of(small_pad());
  BiasEstimator restarted = estimator_of(small_pad());
  restarted.restore(zero_of(sensor));
  sensor.press_everywhere(4 * RawSensor::kNoisePa, 0);
  EXPECT_TRUE(sensor.run(restarted, 1).zeroed);
}

TEST(ZeroCheck, AZeroTakenUnderLoadIsDoubtedOnceTheLoadIsOffAndStaysSoUntilANewOne) {
  for (const bool exchangeable : {false, true}) {
    RawSensor sensor = sensor_of(large_pad());
    BiasEstimator estimator = estimator_of(large_pad(), exchangeable);
    sensor.press(3, 0.5);
    estimator.ask(1, true);
    EXPECT_TRUE(sensor.run(estimator, 2).zeroed);
    sensor.release();
    sensor.run(estimator, 1);
    EXPECT_EQ(estimator.report().doubt, BiasDoubt::below);
    expect_no_zero(estimator, sensor, 1);
    sensor.press(3.2, 0.6);
    expect_no_zero(estimator, sensor, 1);
    sensor.release();
    estimator.ask(2, false);
    EXPECT_TRUE(sensor.run(estimator, 2).zeroed) << to_string(estimator.report().answer);
    EXPECT_EQ(estimator.report().doubt, BiasDoubt::none);
  }
}

TEST(ZeroCheck, OneThatFallsFarBelowWhileFramesComeIsDoubtedWithASerialNumberToo) {
  RawSensor sensor = sensor_of(small_pad());
  BiasEstimator estimator = estimator_of(small_pad(), false);
  estimator.restore(zero_of(sensor));
  EXPECT_TRUE(sensor.run(estimator, 1).zeroed);
  sensor.press_everywhere(-120e3F, 0);
  sensor.run(estimator, 1);
  expect_no_zero(estimator, sensor, 1);
}

TEST(ZeroCheck, SkinThatSpringsBackContradictsNoZero) {
  RawSensor sensor = sensor_of(small_pad());
  BiasEstimator estimator = estimator_of(small_pad());
  estimator.restore(zero_of(sensor));
  constexpr float kPressed = 200e3F;
  EXPECT_TRUE(sensor.run(estimator, 1).zeroed);
  sensor.press_everywhere(kPressed, 0);
  sensor.run(estimator, 1);
  sensor.press_everywhere(-0.04F * kPressed, 0);
  EXPECT_TRUE(sensor.run(estimator, 2).zeroed);
}

TEST(ZeroCheck, WhatIsNoNumberAgreesWithNothing) {
  RawSensor sensor = sensor_of(small_pad());
  const Bias zero = zero_of(sensor);
  const ZeroCheck check(sensor.taxels());
  FrameSlot slot = sensor.read();
  EXPECT_TRUE(check.agrees(slot.view(), zero, {}, {}));
  std::fill(slot.shear_y_pa.begin(), slot.shear_y_pa.end(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(check.agrees(slot.view(), zero, {}, {}));
}

}  // namespace
}  // namespace slipd
