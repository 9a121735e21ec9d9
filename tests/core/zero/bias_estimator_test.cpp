// The bias is measured on request or when the sensor reads zero, never under load. It follows drift while
// the sensor is free, and is constant under load.
#include "core/zero/bias_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/chain/chain.hpp"
#include "core/zero/gain.hpp"
#include "tests/core/zero/raw_sensor.hpp"
#include "tests/support/heap_count.hpp"

namespace slipd {
namespace {

using test::RawSensor;

TaxelLayout pad() {
  return TaxelLayout::grid(24, 24, 0.0006);
}

EstimatorChain make_chain() {
  ChainSetup setup{.layout = pad(), .scene = {}, .estimator = {}, .alerts = {}, .friction = 0.6};
  setup.scene.objects = paper_objects();
  return {setup, nullptr};
}

// Tolerance for a mean over two blocks (202 frames and more), for any of some thousand channels: five
// standard errors.
constexpr float kMeanError = 5 * RawSensor::kNoisePa / 14;

void rebias(BiasEstimator& bias_estimator, RawSensor& sensor, std::uint32_t request = 1, bool force = false) {
  bias_estimator.ask(request, force);
  sensor.run(bias_estimator, 2);
}

TEST(BiasEstimator, TakesTheMeanOfTheFramesAsTheBiasOnRequest) {
  RawSensor sensor(pad());
  BiasEstimator bias_estimator(sensor.layout());
  sensor.run(bias_estimator, 1);
  rebias(bias_estimator, sensor);
  EXPECT_EQ(bias_estimator.report().answered, 1U);
  EXPECT_EQ(bias_estimator.report().answer, BiasResult::taken);
  EXPECT_EQ(bias_estimator.report().origin, BiasOrigin::command);
  EXPECT_LT(sensor.farthest(bias_estimator), kMeanError);
}

TEST(BiasEstimator, MeasuresTheNoise) {
  RawSensor sensor(pad());
  BiasEstimator bias_estimator(sensor.layout());
  rebias(bias_estimator, sensor);
  // 200 frames of 576 taxels: within 2 %.
  EXPECT_NEAR(bias_estimator.report().noise_normal_pa / RawSensor::kNoisePa, 1, 0.02);
  EXPECT_NEAR(bias_estimator.report().noise_shear_pa / RawSensor::kNoisePa, 1, 0.02);
}

TEST(BiasEstimator, MarksEveryFrameWhileTheBiasIsUnknown) {
  RawSensor sensor(pad());
  BiasEstimator bias_estimator(sensor.layout());
  EXPECT_FALSE(sensor.run(bias_estimator, 1).zeroed);
  EXPECT_EQ(bias_estimator.report().origin, BiasOrigin::none) << "offsets are no proof of anything";
  rebias(bias_estimator, sensor);
  EXPECT_TRUE(sensor.run(bias_estimator, 0.01).zeroed);
}

TEST(BiasEstimator, DoesNotTakeALoadForTheBiasWithoutARequest) {
  for (const double normal_n : {0.2, 1.0, 5.0}) {
    RawSensor sensor(pad());
    sensor.without_offsets();
    sensor.press(normal_n, 0.3 * normal_n);
    BiasEstimator bias_estimator(sensor.layout());
    EXPECT_FALSE(sensor.run(bias_estimator, 3).zeroed) << normal_n;
  }
}

TEST(BiasEstimator, ASensorThatReadsZeroNeedsNoRequest) {
  RawSensor sensor(pad());
  sensor.without_offsets();
  BiasEstimator bias_estimator(sensor.layout());
  EXPECT_TRUE(sensor.run(bias_estimator, 1).zeroed);
  EXPECT_EQ(bias_estimator.report().origin, BiasOrigin::no_load);
}

TEST(BiasEstimator, AShakingLoadIsNotTakenForTheBias) {
  // A force sensor shows no shape, and a load that shakes looks like noise about a mean.
  for (const float share : {0.1F, 0.5F, 0.9F}) {
    RawSensor sensor(TaxelLayout::wrench(0.02));
    sensor.without_offsets();
    BiasEstimator bias_estimator(sensor.layout());
    for (int i = 0; i < 5000; ++i) {
      const float load = 20000 * (1 + share * std::sin(0.3F * static_cast<float>(i)));
      sensor.press_everywhere(load, load / 4);
      FrameSlot slot = sensor.read();
      bias_estimator.apply(slot);
      bias_estimator.judge();
    }
    EXPECT_EQ(bias_estimator.report().origin, BiasOrigin::none) << share;
  }
}

// At 20 Hz a block takes 0.8 s; the contact begins in each of its frames in turn.
TEST(BiasEstimator, AContactThatBeginsInAnyFrameOfABlockDoesNotChangeTheBias) {
  for (const float noise_pa : {0.0F, RawSensor::kNoisePa}) {
    for (int free_frames = 0; free_frames < 70; ++free_frames) {
      RawSensor sensor(TaxelLayout::grid(4, 4, 0.0047), noise_pa, 50'000'000);
      sensor.without_offsets();
      BiasEstimator bias_estimator(sensor.layout());
      sensor.run(bias_estimator, 0.05 * free_frames + 0.001);
      sensor.press(3, 0.9);
      sensor.run(bias_estimator, 5);
      sensor.release();
      sensor.run(bias_estimator, 5);
      ASSERT_NE(bias_estimator.report().origin, BiasOrigin::none);
      ASSERT_LE(sensor.farthest(bias_estimator), 6 * noise_pa / std::sqrt(32.0F))
          << free_frames << ", " << noise_pa;
    }
  }
}

TEST(BiasEstimator, RefusesWhileTheReadingMoves) {
  RawSensor sensor(pad());
  BiasEstimator bias_estimator(sensor.layout());
  bias_estimator.ask(1, true);
  for (int i = 0; i < 3000; ++i) {
    sensor.press_everywhere(3 * static_cast<float>(i), 0);
    FrameSlot slot = sensor.read();
    bias_estimator.apply(slot);
    bias_estimator.judge();
  }
  EXPECT_EQ(bias_estimator.report().answer, BiasResult::moving);
  EXPECT_EQ(bias_estimator.report().origin, BiasOrigin::none);
}

TEST(BiasEstimator, RefusesWhatLooksLikeAContactUnlessForced) {
  RawSensor sensor(pad());
  sensor.press(3, 0.5);
  BiasEstimator bias_estimator(sensor.layout());
  // Offsets as large as a load hide the shape of a contact before the first bias. This device has small
  // offsets.
  sensor.without_offsets();
  rebias(bias_estimator, sensor, 1);
  EXPECT_EQ(bias_estimator.report().answer, BiasResult::in_contact);
  EXPECT_EQ(bias_estimator.report().origin, BiasOrigin::none);
  rebias(bias_estimator, sensor, 2, true);
  EXPECT_EQ(bias_estimator.report().answered, 2U);
  EXPECT_EQ(bias_estimator.report().answer, BiasResult::taken);
}

TEST(BiasEstimator, RefusesASensorThatWasFreeAndIsInContactNow) {
  RawSensor sensor(TaxelLayout::wrench(0.02));  // a force sensor, which shows no shape
  BiasEstimator bias_estimator(sensor.layout());
  rebias(bias_estimator, sensor, 1);
  sensor.press_everywhere(20000, 3000);
  rebias(bias_estimator, sensor, 2);
  EXPECT_EQ(bias_estimator.report().answer, BiasResult::in_contact);
  EXPECT_LT(sensor.farthest(bias_estimator), kMeanError) << "and the zero stays";
  sensor.release();
  rebias(bias_estimator, sensor, 3);
  EXPECT_EQ(bias_estimator.report().answer, BiasResult::taken);
}

TEST(BiasEstimator, FollowsDriftWhileTheSensorIsFree) {
  RawSensor sensor(pad());
  BiasEstimator bias_estimator(sensor.layout());
  rebias(bias_estimator, sensor);
  constexpr float kRate = 10;  // Pa/s; in a minute the drift is three times the noise
  sensor.drifts(kRate);
  sensor.run(bias_estimator, 60);
  EXPECT_TRUE(bias_estimator.report().free);
  EXPECT_LT(sensor.farthest(bias_estimator), 10 * kRate + kMeanError) << "what ten seconds of drift make";
  EXPECT_GT(bias_estimator.report().drift_pa, 40 * kRate);
}

TEST(BiasEstimator, FollowsASensorOfCoarseResolution) {
  constexpr float kStep = 500;
  RawSensor sensor(TaxelLayout::grid(4, 4, 0.005), 20);
  sensor.round_to(kStep);
  BiasEstimator bias_estimator(sensor.layout(), {kStep, kStep});
  rebias(bias_estimator, sensor);
  ASSERT_EQ(bias_estimator.report().answer, BiasResult::taken);
  sensor.drifts(10);
  sensor.run(bias_estimator, 120);
  EXPECT_TRUE(bias_estimator.report().free);
  EXPECT_LT(sensor.farthest(bias_estimator), 1.5F * kStep);
  sensor.press_everywhere(3 * kStep, 0);
  sensor.run(bias_estimator, 10);
  EXPECT_FALSE(bias_estimator.report().free);
}

TEST(BiasEstimator, ValuesThatAreNotFiniteDoNotChangeTheBias) {
  RawSensor sensor(pad());
  BiasEstimator bias_estimator(sensor.layout());
  rebias(bias_estimator, sensor);
  for (int i = 0; i < 1000; ++i) {
    FrameSlot slot = sensor.read();
    if (i % 50 == 0) slot.shear_x_pa[7] = std::numeric_limits<float>::quiet_NaN();
    bias_estimator.apply(slot);
    bias_estimator.judge();
  }
  EXPECT_FALSE(bias_estimator.report().free);
  EXPECT_LT(sensor.farthest(bias_estimator), kMeanError);
  sensor.run(bias_estimator, 1);
  EXPECT_TRUE(bias_estimator.report().free);
}

TEST(BiasEstimator, KeepsTheBiasUnderLoad) {
  for (const bool everywhere : {false, true}) {
    RawSensor sensor(pad());
    BiasEstimator bias_estimator(sensor.layout());
    rebias(bias_estimator, sensor);
    const auto before = bias_estimator.zero().bias_pa;
    if (everywhere) {
      sensor.press_everywhere(3000, 500);
    } else {
      sensor.press(0.3, 0.05);
    }
    sensor.run(bias_estimator, 60);
    EXPECT_FALSE(bias_estimator.report().free);
    for (std::size_t i = 0; i < before.size(); ++i)
      ASSERT_NEAR(bias_estimator.zero().bias_pa[i], before[i], 0.02 * RawSensor::kNoisePa)
          << "but for the block in which it was touched";
  }
}

TEST(BiasEstimator, FollowsAgainAfterDriftUnderLoad) {
  RawSensor sensor(pad());
  BiasEstimator bias_estimator(sensor.layout());
  rebias(bias_estimator, sensor);
  sensor.drifts(8);
  sensor.press(3, 0.5);
  sensor.run(bias_estimator, 40);
  EXPECT_FALSE(bias_estimator.report().free);
  sensor.release();
  sensor.run(bias_estimator, 60);
  EXPECT_TRUE(bias_estimator.report().free);
  EXPECT_LT(sensor.farthest(bias_estimator), 10 * 8 + kMeanError);
}

TEST(BiasEstimator, ARestoredBiasIsValidInMidGrasp) {
  RawSensor sensor(pad());
  BiasEstimator first(sensor.layout());
  rebias(first, sensor);
  sensor.press(3, 0.8);

  BiasEstimator second(sensor.layout());
  second.restore(first.zero());
  EXPECT_TRUE(second.report().restored);
  EstimatorChain before = make_chain();
  EstimatorChain after = make_chain();
  Estimate estimate_before, estimate_after;
  for (int i = 0; i < 1000; ++i) {
    FrameSlot slot = sensor.read();
    first.apply(slot);
    first.judge();
    estimate_before = before.estimate(slot.view());
    slot = sensor.read();
    second.apply(slot);
    second.judge();
    estimate_after = after.estimate(slot.view());
  }
  ASSERT_EQ(estimate_before.state, State::ok);
  ASSERT_EQ(estimate_after.state, State::ok);
  EXPECT_NEAR(*estimate_after.gamma, *estimate_before.gamma,
              3 * (*estimate_before.sigma + *estimate_after.sigma));
  EXPECT_NEAR(*estimate_after.normal_n, 3, 0.05);
  EXPECT_LT(sensor.farthest(second), kMeanError);
}

TEST(BiasEstimator, WithoutABiasTheChainGivesStateUnzeroedAndNoNumber) {
  RawSensor sensor(pad());
  sensor.press(3, 0.8);
  BiasEstimator bias_estimator(sensor.layout());
  EstimatorChain chain = make_chain();
  const Estimate estimate = chain.estimate(sensor.run(bias_estimator, 0.5).view());
  EXPECT_EQ(estimate.state, State::unzeroed);
  EXPECT_FALSE(estimate.gamma || estimate.normal_n || estimate.shear_n || estimate.friction);
  EXPECT_EQ(estimate.alert, Alert::unknown);
}

TEST(BiasEstimator, AfterAReplugAHeldLoadIsNotTakenForDriftAndARequestIsAnswered) {
  RawSensor sensor(pad());
  BiasEstimator bias_estimator(sensor.layout());
  rebias(bias_estimator, sensor);
  sensor.press(3, 0.5);
  bias_estimator.ask(2, false);
  bias_estimator.reopened();
  EXPECT_EQ(bias_estimator.report().answer, BiasResult::gone);
  sensor.run(bias_estimator, 10);
  EXPECT_FALSE(bias_estimator.report().free);
  EXPECT_LT(sensor.farthest(bias_estimator), kMeanError);
  rebias(bias_estimator, sensor, 3);
  EXPECT_EQ(bias_estimator.report().answer, BiasResult::in_contact)
      << "by its shape, against the zero that is known";
}

TEST(Gain, MultipliesAllChannelsOfItsTaxel) {
  std::vector<float> memory{1, 2, 3, 4, 5, 6};
  FrameSlot slot;
  slot.normal_pa = std::span(memory).first(2);
  slot.shear_x_pa = std::span(memory).subspan(2, 2);
  slot.shear_y_pa = std::span(memory).last(2);
  apply_gain(std::vector<float>{2, 10}, slot);
  EXPECT_EQ(memory, (std::vector<float>{2, 20, 6, 40, 10, 60}));
}

TEST(BiasEstimator, RefusesTheBiasOfAnotherSensor) {
  BiasEstimator bias_estimator(pad());
  const Bias other{.bias_pa = std::vector<float>(9), .noise_pa = std::vector<float>(9)};
  EXPECT_THROW(bias_estimator.restore(other), std::invalid_argument);
}

TEST(BiasEstimator, AllocatesNothingWhileFramesCome) {
  RawSensor sensor(pad());
  BiasEstimator bias_estimator(sensor.layout());
  bias_estimator.ask(1, false);
  std::uint64_t allocated = 0;
  for (int i = 0; i < 1000; ++i) {
    FrameSlot slot = sensor.read();
    const auto before = test::allocations();
    bias_estimator.apply(slot);
    bias_estimator.judge();
    allocated += test::allocations() - before;
  }
  EXPECT_EQ(bias_estimator.report().answer, BiasResult::taken);
  EXPECT_EQ(allocated, 0U);
}

}  // namespace
}  // namespace slipd
