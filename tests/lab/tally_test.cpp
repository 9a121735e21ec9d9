// Estimates counted against the truth.
#include "lab/tally/tally.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "lab/tally/block_share.hpp"
#include "lab/tally/samples.hpp"
#include "lab/torque/measure.hpp"

namespace lab {
namespace {

using slipd::Estimate;
using slipd::State;

Estimate margin_estimate(double gamma, double sigma) {
  Estimate out;
  out.state = State::ok;
  out.gamma = gamma;
  out.sigma = sigma;
  return out;
}

TEST(Tally, CountsErrorsBeyondTheLimitOnEachSide) {
  Tally tally;
  tally.add(margin_estimate(0.5, 0.1), {.gamma = 0.5});
  tally.add(margin_estimate(0.75, 0.1), {.gamma = 0.5});
  tally.add(margin_estimate(0.1, 0.3), {.gamma = 0.5});
  tally.add(Estimate{}, {.gamma = 0.5});
  EXPECT_EQ(tally.frames(), 4);
  EXPECT_DOUBLE_EQ(tally.answered(), 0.75);
  EXPECT_DOUBLE_EQ(tally.overestimated(), 1.0 / 3);
  EXPECT_DOUBLE_EQ(tally.underestimated(), 1.0 / 3);
  EXPECT_NEAR(tally.mean_error(), (0.25 + 0.4) / 3, 1e-12);
  EXPECT_DOUBLE_EQ(tally.within(1), 1.0 / 3);
  EXPECT_DOUBLE_EQ(tally.within(2), 2.0 / 3);
  EXPECT_DOUBLE_EQ(tally.in_state(State::stale), 0.25);
}

TEST(Tally, WithoutAnAnswerThereIsNoError) {
  Tally tally;
  tally.add(Estimate{}, {.gamma = 0.5});
  EXPECT_TRUE(std::isnan(tally.mean_error()));
  EXPECT_EQ(tally.answered(), 0);
}

TEST(Tally, OfTwoIsThatOfAllTheirFrames) {
  Tally one, other, all;
  for (const double gamma : {0.1, 0.45, 0.9}) {
    one.add(margin_estimate(gamma, 0.1), {.gamma = 0.4});
    all.add(margin_estimate(gamma, 0.1), {.gamma = 0.4});
  }
  for (Tally* tally : {&other, &all}) {
    tally->add(margin_estimate(0.7, 0.05), {.gamma = 0.75});
    tally->add(Estimate{}, {.gamma = 0.75});
  }
  one.add(other);
  EXPECT_EQ(one.frames(), all.frames());
  EXPECT_EQ(one.answers(), 4);
  EXPECT_EQ(one.in_state(State::stale), all.in_state(State::stale));
  EXPECT_NEAR(one.mean_error(), all.mean_error(), 1e-15);
  EXPECT_NEAR(one.bias(), all.bias(), 1e-15);
  EXPECT_EQ(one.worst(), all.worst());
  EXPECT_EQ(one.most_above(), all.most_above());
  EXPECT_EQ(one.overestimates(), all.overestimates());
  EXPECT_EQ(one.beyond(2), all.beyond(2));
  EXPECT_EQ(one.least_sigma(), 0.05);
}

TEST(Tally, CountsBoundsThatAreAboveTheTruthAndClearlySo) {
  Tally tally;
  for (const double low : {0.3, 0.45, 0.61}) {
    Estimate estimate;
    estimate.gamma_low = low;
    tally.add(estimate, {.gamma = 0.5});
  }
  EXPECT_DOUBLE_EQ(tally.low_above(), 1.0 / 3);
  EXPECT_DOUBLE_EQ(tally.low_clearly_above(), 1.0 / 3);
  Estimate estimate;
  estimate.gamma_low = 0.55;
  tally.add(estimate, {.gamma = 0.5});
  EXPECT_DOUBLE_EQ(tally.low_above(), 0.5);
  EXPECT_DOUBLE_EQ(tally.low_clearly_above(), 0.25);
}

// Blocks whose frames are all alike, drawn many times: the shares scatter as sigma says, which is more than
// frames drawn one by one would.
TEST(BlockShare, ScattersByItsSigma) {
  std::mt19937_64 random(1);
  std::bernoulli_distribution bad(0.2);
  std::uniform_int_distribution<int> frames(50, 150);
  constexpr int kBlocks = 60, kTrials = 400;
  double sum = 0, square = 0, told = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    BlockShare share;
    for (int block = 0; block < kBlocks; ++block) {
      const int count = frames(random);
      share.add(bad(random) ? count : 0, count);
    }
    sum += share.share();
    square += share.share() * share.share();
    told += share.sigma();
  }
  const double mean = sum / kTrials, scatter = std::sqrt(square / kTrials - mean * mean);
  EXPECT_NEAR(mean, 0.2, 0.01);
  EXPECT_NEAR(told / kTrials / scatter, 1, 0.1);
  EXPECT_TRUE(std::isnan(BlockShare().share()));
}

TEST(TorqueTally, CountsErrorsAboveTheTruthAndFrictionWhereSlipIsNear) {
  TorqueTally tally;
  Estimate estimate = margin_estimate(0.7, 0.05);
  estimate.friction = 0.55;
  tally.add(estimate, {.gamma = 0.5, .friction = 0.5}, 3);
  estimate.gamma = 0.4;
  estimate.friction = 0.5;
  tally.add(estimate, {.gamma = 0.5, .friction = 0.4}, 5);
  tally.add(Estimate{}, {.gamma = 0.9, .friction = 0.4}, 4);
  EXPECT_DOUBLE_EQ(tally.margins.overestimated(), 0.5);
  EXPECT_NEAR(tally.margins.most_above(), 0.2, 1e-12);
  EXPECT_NEAR(tally.margins.bias(), 0.05, 1e-12);
  EXPECT_NEAR(tally.near.friction_error(), (0.1 + 0.25) / 2, 1e-12);
  EXPECT_DOUBLE_EQ(tally.near.answered(), 1);
  EXPECT_DOUBLE_EQ(tally.taken_us.median(), 4);
}

TEST(Samples, AreRankedWhateverTheirOrder) {
  Samples samples;
  EXPECT_TRUE(std::isnan(samples.median()));
  EXPECT_TRUE(std::isnan(samples.quantile(0.5)));
  for (const double value : {5, 1, 4, 2, 3}) samples.add(value);
  EXPECT_EQ(samples.median(), 3);
  EXPECT_EQ(samples.quantile(0), 1);
  EXPECT_EQ(samples.quantile(0.75), 4);
  EXPECT_EQ(samples.quantile(1), 5);
}

}  // namespace
}  // namespace lab
