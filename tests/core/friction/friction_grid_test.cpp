// The grid of friction: its prior, and what its weights say of friction and margin.
#include "core/friction/friction_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/frame/model_errors.hpp"

namespace slipd {
namespace {

constexpr FrictionPrior kPrior{.expected = {0.1, 0.9}, .spread = 0.15};
constexpr std::size_t kCount = 56;

// Weights of a Gaussian of `sigma` in log mu about mu.
void believe(FrictionGrid& grid, double mu, double sigma) {
  std::vector<double> weights(grid.count());
  for (std::size_t j = 0; j < grid.count(); ++j) {
    const double off = std::log(grid.friction(j) / mu) / sigma;
    weights[j] = std::exp(-0.5 * off * off);
  }
  grid.assign(weights);
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

TEST(FrictionGrid, SaysWhatFrictionExceedsWith95PercentAlsoWhereItMayHaveFallen) {
  FrictionGrid grid(kPrior, kCount);
  EXPECT_LT(grid.least_friction(0), 0.13) << "nothing is known";
  believe(grid, 0.5, 0.1);
  EXPECT_NEAR(grid.least_friction(0), 0.5 * std::exp(-1.645 * 0.1), 0.01);
  EXPECT_LT(grid.least_friction(0.2), 0.5 - 1.645 * 0.2 * 0.5) << "what all frames have in common";
  std::vector<double> weights(grid.count());
  for (std::size_t j = 0; j < grid.count(); ++j) weights[j] = grid.weight(j);
  const std::size_t fallen = grid.count() / 3;
  weights[fallen] += 0.1;
  grid.assign(weights);
  EXPECT_LT(grid.least_friction(0), 1.05 * grid.friction(fallen));
  EXPECT_NEAR(grid.friction().mean, 0.5, 0.02) << "and its median stays";
}

TEST(FrictionGrid, GivesMedianAndSigmaOfItsWeightsBetweenItsPoints) {
  for (const double mu : {0.12, 0.303, 0.71}) {
    FrictionGrid grid(kPrior, kCount);
    believe(grid, mu, 0.15);
    EXPECT_NEAR(grid.friction().mean, mu, 0.003 * mu);
    EXPECT_NEAR(grid.friction().sigma, 0.15 * mu, 0.01 * mu);
    EXPECT_NEAR(grid.inverse_friction().mean, 1 / mu, 0.003 / mu);
    EXPECT_NEAR(grid.inverse_friction().sigma, 0.15 / mu, 0.01 / mu);
  }
}

TEST(FrictionGrid, ASmallWeightFarAwayWidensTheMarginsSigmaAndNotTheFriction) {
  FrictionGrid sure(kPrior, kCount), changed(kPrior, kCount);
  believe(sure, 0.5, 0.1);
  std::vector<double> weights(kCount);
  for (std::size_t j = 0; j < kCount; ++j)
    weights[j] = 0.95 * sure.weight(j) + (std::fabs(sure.friction(j) - 0.25) < 0.01 ? 0.05 : 0);
  changed.assign(weights);
  EXPECT_NEAR(changed.friction().mean, sure.friction().mean, 0.02);
  EXPECT_NEAR(changed.friction().sigma, sure.friction().sigma, 0.02);
  EXPECT_GT(changed.margin(0.2, 0).sigma, 1.5 * sure.margin(0.2, 0).sigma);
}

TEST(FrictionGrid, SigmaHasAFloorHoweverSharpItsWeightsAre) {
  const FrictionGridOptions options;
  FrictionGrid grid(kPrior, kCount, options);
  believe(grid, 0.4, 0.001);
  const MeanSigma mu = grid.friction(), margin = grid.margin(0.2, 0);
  EXPECT_GE(mu.sigma, kUnevenShare * mu.mean);
  EXPECT_LT(mu.sigma, 3 * kUnevenShare * mu.mean);
  EXPECT_GE(margin.sigma, kUnevenShare * (1 - margin.mean));
}

TEST(FrictionGrid, FrictionFarOutsideTheSceneHasAPriorAsWell) {
  const FrictionGrid grid({.expected = {0.5, 0.5}, .spread = 0.05}, kCount);
  for (std::size_t j = 0; j < grid.count(); ++j) EXPECT_GT(grid.prior(j), 0) << grid.friction(j);
}

TEST(FrictionGrid, ANewGraspForgetsAllAndWeightsThatSayNothingToo) {
  const FrictionGrid fresh(kPrior, kCount);
  for (const bool by_reset : {true, false}) {
    FrictionGrid grid(kPrior, kCount);
    believe(grid, 0.4, 0.1);
    if (by_reset) {
      grid.reset();
    } else {
      grid.assign(std::vector<double>(kCount));
    }
    EXPECT_EQ(grid.friction().mean, fresh.friction().mean);
    EXPECT_EQ(grid.friction().sigma, fresh.friction().sigma);
  }
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
