// The posterior of friction over frames: what it learns, how soon it learns a change, and what frames that
// share an error count for.
#include "core/friction/friction_posterior.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/numeric/random.hpp"
#include "tests/support/heap_count.hpp"

namespace slipd {
namespace {

constexpr FrictionPrior kScene{.expected = {0.1, 0.9}, .spread = 0.15};
constexpr std::size_t kPoints = 56;
constexpr double kFrame_s = 0.005;

// A frame that shows log mu with these errors, of which `common` is the same in all frames.
void frame_says(FrictionPosterior& posterior, double mu, double common, double noise) {
  std::vector<double> residuals(kPoints);
  for (std::size_t j = 0; j < kPoints; ++j) residuals[j] = std::log(mu / posterior.grid().friction(j));
  posterior.begin(kFrame_s);
  posterior.weigh(Evidence::margin, residuals, common, noise);
  posterior.conclude();
}

int frames_until(FrictionPosterior& posterior, double mu, double common, double noise) {
  for (int frames = 1; frames < 1000; ++frames) {
    frame_says(posterior, mu, common, noise);
    if (std::fabs(std::log(posterior.grid().friction().mean / mu)) < 0.1) return frames;
  }
  return 1000;
}

double sigma_of(const FrictionPosterior& posterior) {
  const MeanSigma mu = posterior.grid().friction();
  return mu.sigma / mu.mean;
}

TEST(FrictionPosterior, LearnsWhatFramesSay) {
  for (const double mu : {0.12, 0.3, 0.7}) {
    FrictionPosterior posterior(kScene, kPoints);
    for (int i = 0; i < 20; ++i) frame_says(posterior, mu, 0.05, 0.2);
    EXPECT_NEAR(posterior.grid().friction().mean, mu, 0.03 * mu);
  }
}

// What all frames have in common no number of them takes away: Gauss 1823.
TEST(FrictionPosterior, AThousandFramesAlikeAreNoSurerThanWhatTheyHaveInCommon) {
  for (const double common : {0.1, 0.2}) {
    FrictionPosterior posterior(kScene, kPoints);
    for (int i = 0; i < 1000; ++i) frame_says(posterior, 0.4, common, 0.1);
    EXPECT_GT(sigma_of(posterior), 0.8 * common);
    EXPECT_LT(sigma_of(posterior), 1.6 * common);
  }
}

TEST(FrictionPosterior, ErrorsThatHavePartedAreAveraged) {
  FrictionPosterior together(kScene, kPoints), parted(kScene, kPoints);
  for (int i = 0; i < 30; ++i) {
    frame_says(together, 0.4, 0.2, 0.05);
    frame_says(parted, 0.4, 0.2, 0.05);
    parted.decorrelate(1);
  }
  EXPECT_LT(sigma_of(parted), 0.7 * sigma_of(together));
}

// Sigma against the error over many grasps: 68 and 95 % of a Gaussian.
TEST(FrictionPosterior, SigmaIsAsLargeAsTheErrorOverManyGrasps) {
  constexpr int kGrasps = 400;
  constexpr double kCommon = 0.15, kNoise = 0.1;
  int within[2] = {};
  const auto normal = [](const RandomStream& random, std::uint64_t i) {
    return std::sqrt(-2 * std::log(1 - random.uniform(2 * i))) *
           std::cos(2 * M_PI * random.uniform(2 * i + 1));
  };
  for (std::uint64_t grasp = 0; grasp < kGrasps; ++grasp) {
    const RandomStream random(grasp);
    const double mu = 0.2 * std::pow(3, random.uniform(1000));
    const double error = kCommon * normal(random, 600);
    FrictionPosterior posterior(kScene, kPoints);
    for (std::uint64_t i = 0; i < 60; ++i)
      frame_says(posterior, mu * std::exp(error + kNoise * normal(random, i)), kCommon, kNoise);
    const double off = std::fabs(std::log(posterior.grid().friction().mean / mu)) / sigma_of(posterior);
    for (int sigmas = 1; sigmas <= 2; ++sigmas) within[sigmas - 1] += off < sigmas ? 1 : 0;
  }
  EXPECT_NEAR(within[0] / double{kGrasps}, 0.68, 0.1);
  EXPECT_GT(within[1] / double{kGrasps}, 0.92);
}

TEST(FrictionPosterior, AChangeIsLearntWithinAFewFramesAfterAnyNumberOfFrames) {
  for (const int before : {30, 30000}) {
    FrictionPosterior posterior(kScene, kPoints);
    for (int i = 0; i < before; ++i) frame_says(posterior, 0.6, 0.03, 0.05);
    EXPECT_LE(frames_until(posterior, 0.3, 0.03, 0.05), 5) << "after " << before;
  }
}

TEST(FrictionPosterior, FrictionThatFallsIsLearntSoonerThanFrictionThatRises) {
  FrictionPosterior falls(kScene, kPoints), rises(kScene, kPoints);
  for (int i = 0; i < 100; ++i) {
    frame_says(falls, 0.6, 0.05, 0.5);
    frame_says(rises, 0.3, 0.05, 0.5);
  }
  EXPECT_LT(frames_until(falls, 0.3, 0.05, 0.5), frames_until(rises, 0.6, 0.05, 0.5));
}

TEST(FrictionPosterior, OneWildFrameChangesNothingHoweverWildItIs) {
  FrictionPosterior posterior(kScene, kPoints);
  for (int i = 0; i < 100; ++i) frame_says(posterior, 0.4, 0.05, 0.1);
  for (const double wild : {1e-9, 1e9}) {
    frame_says(posterior, wild, 0.05, 0.1);
    EXPECT_NEAR(posterior.grid().friction().mean, 0.4, 0.03);
  }
}

TEST(FrictionPosterior, WithoutFramesFrictionIsForgotten) {
  FrictionPosteriorOptions options;
  options.falls_per_s = options.rises_per_s = 1;
  FrictionPosterior posterior(kScene, kPoints, options);
  const double open = sigma_of(posterior);
  for (int i = 0; i < 20; ++i) frame_says(posterior, 0.4, 0.05, 0.1);
  posterior.begin(0.1);
  posterior.conclude();
  EXPECT_LT(sigma_of(posterior), 0.2 * open);
  posterior.begin(100);
  posterior.conclude();
  EXPECT_NEAR(sigma_of(posterior), open, 0.05 * open);
}

// Noise of a load at friction's limit: half of the frames are above it.
TEST(FrictionPosterior, ALoadThatIsHeldBoundsFrictionAndManyFramesOfItNoMoreThanOne) {
  FrictionPosterior once(kScene, kPoints), often(kScene, kPoints);
  for (int i = 0; i < 300; ++i) {
    for (FrictionPosterior* const posterior : {&once, &often}) {
      posterior->begin(1e-6);
      if (i == 0 || posterior == &often) posterior->bound_below({0.4, 0.01});
      posterior->conclude();
    }
  }
  for (std::size_t j = 0; j < kPoints; ++j) {
    EXPECT_NEAR(often.grid().weight(j), once.grid().weight(j), 1e-3);
    if (once.grid().friction(j) < 0.36) {
      EXPECT_LT(once.grid().weight(j), 1e-3);
    }
  }
}

// As forces do whose noise is larger than it is taken for: friction is high, and not what was expected first.
TEST(FrictionPosterior, ALoadHeldFarAboveAllFrictionsLeavesTheHighest) {
  FrictionPosterior posterior(kScene, kPoints);
  for (int i = 0; i < 100; ++i) frame_says(posterior, 0.3, 0.05, 0.05);
  const double highest = posterior.grid().friction(kPoints - 1);
  posterior.begin(kFrame_s);
  posterior.bound_below({1.2 * highest, 0.02 * highest});
  posterior.conclude();
  EXPECT_GT(posterior.grid().friction().mean, 0.8 * highest);
}

TEST(FrictionPosterior, SaysWhichFrictionsHaveJustBecomeSo) {
  FrictionPosterior posterior(kScene, kPoints);
  posterior.begin(kFrame_s);
  EXPECT_FALSE(posterior.conclude()) << "all are open, and as likely before as now";
  for (int i = 0; i < 100; ++i) frame_says(posterior, 0.6, 0.03, 0.05);
  posterior.begin(kFrame_s);
  EXPECT_TRUE(posterior.conclude());
  const std::size_t likeliest = posterior.grid().likeliest();
  EXPECT_FALSE(posterior.has_changed(likeliest));
  EXPECT_TRUE(posterior.has_changed(likeliest / 2)) << "refuted for as long as it was not a new one";
}

TEST(FrictionPosterior, AllocatesNothing) {
  FrictionPosterior posterior(kScene, kPoints);
  const std::vector<double> residuals(kPoints, 0.1);
  const auto before = test::allocations();
  for (int i = 0; i < 100; ++i) {
    posterior.begin(kFrame_s);
    posterior.bound_below({0.2, 0.01});
    posterior.weigh(Evidence::margin, residuals, 0.1, 0.1);
    posterior.conclude();
    posterior.decorrelate(0.1);
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace slipd
