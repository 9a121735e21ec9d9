// The posterior of friction: its prior, its floors and its recovery.
#include "core/friction/friction_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace slipd {
namespace {

constexpr FrictionPrior kPrior{.expected = {0.1, 0.9}, .spread = 0.15};
constexpr std::size_t kCount = 56;

std::size_t nearest(const FrictionGrid& grid, double mu) {
  std::size_t best = 0;
  for (std::size_t j = 1; j < grid.count(); ++j) {
    if (std::fabs(std::log(grid.friction(j) / mu)) < std::fabs(std::log(grid.friction(best) / mu))) best = j;
  }
  return best;
}

// A frame whose likelihood is a Gaussian of `sigma` in log mu about mu; the best friction loses nothing.
void frame_says(FrictionGrid& grid, double mu, double sigma) {
  const auto nats = [&](std::size_t j) {
    const double off = std::log(grid.friction(j) / mu) / sigma;
    return 0.5 * off * off;
  };
  const double least = nats(nearest(grid, mu));
  for (std::size_t j = 0; j < grid.count(); ++j) grid.take(j, nats(j) - least);
  grid.normalise();
}

int frames_until(FrictionGrid& grid, double mu, double sigma) {
  for (int frames = 1; frames < 1000; ++frames) {
    frame_says(grid, mu, sigma);
    if (std::fabs(std::log(grid.friction().mean / mu)) < 0.1) return frames;
  }
  return 1000;
}

TEST(FrictionPrior, IsFlatWithinTheRangeAndFallsAsAGaussianBeyondIt) {
  for (const double mu : {0.1, 0.3, 0.9}) EXPECT_EQ(kPrior.nats_against(mu), 0);
  for (const double sigmas : {0.5, 1.0, 3.0}) {
    EXPECT_NEAR(kPrior.nats_against(0.9 * std::exp(sigmas * 0.15)), 0.5 * sigmas * sigmas, 1e-12);
    EXPECT_NEAR(kPrior.nats_against(0.1 * std::exp(-sigmas * 0.15)), 0.5 * sigmas * sigmas, 1e-12);
  }
}

TEST(PosteriorSums, GiveMeanAndVarianceOfWeightsThatNeedNotSumToOne) {
  PosteriorSums sums;
  for (const auto& [weight, value] : {std::pair{2.0, 1.0}, {1.0, 4.0}, {1.0, 6.0}}) sums.add(weight, value);
  EXPECT_DOUBLE_EQ(sums.mean(), 3);
  EXPECT_DOUBLE_EQ(sums.variance(), 4.5);
}

TEST(PosteriorSums, OfOneValueHaveNoVarianceWhateverRoundingDoes) {
  PosteriorSums sums;
  for (int i = 0; i < 1000; ++i) sums.add(1e-3, 0.1);
  EXPECT_GE(sums.variance(), 0);
  EXPECT_LT(sums.variance(), 1e-15);
}

TEST(FrictionGrid, WithoutFramesIsTheScenesRange) {
  const FrictionGrid grid(kPrior, kCount);
  const MeanSigma mu = grid.friction();
  EXPECT_GT(mu.mean, 0.1);
  EXPECT_LT(mu.mean, 0.9);
  EXPECT_GT(mu.sigma, 0.5 * mu.mean) << "wide open";
}

TEST(FrictionGrid, LearnsWhatFramesSay) {
  for (const double mu : {0.12, 0.3, 0.7}) {
    FrictionGrid grid(kPrior, kCount);
    for (int i = 0; i < 20; ++i) frame_says(grid, mu, 0.2);
    EXPECT_NEAR(grid.friction().mean, mu, 0.03 * mu);
  }
}

TEST(FrictionGrid, SigmaHasAFloorHoweverSharpTheFramesAre) {
  const FrictionGridOptions options;
  FrictionGrid grid(kPrior, kCount, options);
  for (int i = 0; i < 1000; ++i) frame_says(grid, 0.4, 0.001);
  const MeanSigma mu = grid.friction();
  EXPECT_GE(mu.sigma, options.sigma_floor * mu.mean);
  EXPECT_LT(mu.sigma, 3 * options.sigma_floor * mu.mean);
  const MeanSigma margin = grid.margin(0.2, 0);
  EXPECT_GE(margin.sigma, 0.99 * options.sigma_floor * (1 - margin.mean));
}

TEST(FrictionGrid, OneFrameHasLimitedWeight) {
  FrictionGridOptions options;
  options.max_frame_nats = 3;
  options.refuted_nats = 8;
  FrictionGrid grid(kPrior, kCount, options);
  const std::size_t j = nearest(grid, 0.3);
  for (int frame = 0; frame < 2; ++frame) grid.take(j, 1e9);
  EXPECT_FALSE(grid.refuted(j)) << "6 nats of two frames";
  grid.take(j, 1e9);
  EXPECT_TRUE(grid.refuted(j));
}

TEST(FrictionGrid, RefutedFrictionRecoversWithinAFewFramesAfterAnyNumberOfFrames) {
  for (const int against : {30, 30000}) {
    FrictionGrid grid(kPrior, kCount);
    for (int i = 0; i < against; ++i) frame_says(grid, 0.6, 0.05);
    EXPECT_TRUE(grid.refuted(nearest(grid, 0.3)));
    EXPECT_LE(frames_until(grid, 0.3, 0.3), 15) << "after " << against;
  }
}

TEST(FrictionGrid, FrictionThatFallsIsLearntSoonerThanFrictionThatRises) {
  FrictionGrid falls(kPrior, kCount), rises(kPrior, kCount);
  for (int i = 0; i < 100; ++i) {
    frame_says(falls, 0.6, 0.05);
    frame_says(rises, 0.3, 0.05);
  }
  EXPECT_LT(frames_until(falls, 0.3, 0.3), frames_until(rises, 0.6, 0.3));
}

TEST(FrictionGrid, FrictionFarOutsideTheSceneIsLearntAsWell) {
  FrictionGrid grid({.expected = {0.5, 0.5}, .spread = 0.05}, kCount);
  EXPECT_LT(frames_until(grid, 0.2, 0.05), 1000);
}

TEST(FrictionGrid, FadesToItsPrior) {
  const FrictionGrid fresh(kPrior, kCount);
  FrictionGrid grid(kPrior, kCount);
  for (int i = 0; i < 10; ++i) frame_says(grid, 0.4, 0.1);
  const MeanSigma learnt = grid.friction();
  grid.fade(1);
  EXPECT_EQ(grid.friction().mean, learnt.mean);
  grid.fade(0.1);
  EXPECT_GT(grid.friction().sigma, 2 * learnt.sigma);
  grid.fade(0);
  EXPECT_EQ(grid.friction().mean, fresh.friction().mean);
}

TEST(FrictionGrid, ANewGraspForgetsAll) {
  const FrictionGrid fresh(kPrior, kCount);
  FrictionGrid grid(kPrior, kCount);
  frame_says(grid, 0.4, 0.1);
  grid.reset();
  EXPECT_EQ(grid.friction().mean, fresh.friction().mean);
  EXPECT_EQ(grid.friction().sigma, fresh.friction().sigma);
}

// The closed form near a sharp peak gives the same margin as the sum over the whole grid.
TEST(FrictionGrid, MarginOfASharpFrictionIsThatOfTheSum) {
  FrictionGridOptions summed;
  summed.sharp_sigma = 0;
  FrictionGrid closed_form(kPrior, FrictionGrid::kMost), sum(kPrior, FrictionGrid::kMost, summed);
  for (FrictionGrid* grid : {&closed_form, &sum}) {
    for (int i = 0; i < 4; ++i) frame_says(*grid, 0.5, 0.1);
  }
  const MeanSigma a = closed_form.margin(0.3, 0.01), b = sum.margin(0.3, 0.01);
  EXPECT_NEAR(a.mean, 0.4, 0.01);
  EXPECT_NEAR(a.mean, b.mean, 0.005);
  EXPECT_NEAR(a.sigma, b.sigma, 0.2 * b.sigma);
}

TEST(FrictionGrid, MarginStaysWithinItsRange) {
  FrictionGrid grid(kPrior, kCount);
  for (const double load : {0.0, 0.05, 0.5, 5.0}) {
    const MeanSigma margin = grid.margin(load, 0.01);
    EXPECT_GE(margin.mean, 0);
    EXPECT_LE(margin.mean, 1);
    EXPECT_TRUE(std::isfinite(margin.sigma));
  }
}

}  // namespace
}  // namespace slipd
