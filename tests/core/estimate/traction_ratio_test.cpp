// The filtered traction ratio of a sensor without shape: it follows the ratio closely, and its sigma covers
// its error.
#include "core/estimate/traction_ratio.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slipd {
namespace {

constexpr double kNoiseN = 0.06;  // of each force

// A patch whose forces have noise.
class Readings {
 public:
  ContactPatch of(double normal_n, double shear_n) {
    ContactPatch patch;
    patch.in_contact = true;
    patch.normal_n = normal_n + noise_(random_);
    patch.shear_n = std::fabs(shear_n + noise_(random_));
    patch.normal_sigma_n = patch.shear_sigma_n = kNoiseN;
    return patch;
  }

 private:
  std::mt19937 random_{5};
  std::normal_distribution<double> noise_{0, kNoiseN};
};

TEST(TractionRatioFilter, OfManyFramesIsFarBetterThanOfOne) {
  Readings readings;
  TractionRatioFilter carried(true);
  double squares = 0, within = 0;
  const int frames = 2000, settling = 50;
  for (int i = 0; i < frames + settling; ++i) {
    carried.update(readings.of(3, 0.9));
    if (i < settling) continue;
    const double off = carried.now().mean - 0.3;
    squares += off * off;
    within += std::fabs(off) < carried.now().sigma ? 1 : 0;
  }
  EXPECT_LT(std::sqrt(squares / frames), 0.5 * kNoiseN / 3);
  EXPECT_GT(within / frames, 0.6);
  EXPECT_LT(within / frames, 0.85);
}

// Loads that rise, stay and fall in 40 frames each: the lag stays within the given sigma.
TEST(TractionRatioFilter, FollowsALoadThatTurns) {
  Readings readings;
  TractionRatioFilter carried(true);
  double within = 0, worst = 0;
  const int frames = 4000, leg = 40;
  for (int i = 0; i < frames; ++i) {
    const double part = static_cast<double>(i % leg) / leg;
    const double legs[] = {part, 1, 1 - part, 0}, load = 0.1 + 0.4 * legs[i / leg % 4];
    carried.update(readings.of(3, 3 * load));
    const double off = std::fabs(carried.now().mean - load);
    within += off < 2 * carried.now().sigma ? 1 : 0;
    worst = std::max(worst, off);
  }
  EXPECT_GT(within / frames, 0.85);
  EXPECT_LT(worst, 5 * kNoiseN / 3);
}

TEST(TractionRatioFilter, FollowsAJumpAtOnce) {
  TractionRatioFilter carried(true);
  Readings readings;
  for (int i = 0; i < 100; ++i) carried.update(readings.of(3, 0.3));
  carried.update(readings.of(3, 2.1));
  EXPECT_NEAR(carried.now().mean, 0.7, 3 * kNoiseN / 3);
}

TEST(TractionRatioFilter, NoiseInTheNormalForceIsNotTakenForSliding) {
  for (const double normal_n : {0.3, 0.5, 1.0, 3.0}) {
    TractionRatioFilter carried(true);
    Readings readings;
    for (int i = 0; i < 5000; ++i) {
      carried.update(readings.of(normal_n, 0.4 * normal_n));
      ASSERT_FALSE(carried.detect_slide()) << normal_n << " N, frame " << i;
    }
  }
}

TEST(TractionRatioFilter, AnEvenRatioWhileTheGripFallsIsSliding) {
  TractionRatioFilter carried(true);
  Readings readings;
  std::optional<double> slides;
  for (int i = 0; i < 200 && !slides; ++i) {
    const double normal_n = i < 50 ? 3 : 3 - 0.01 * (i - 50);
    carried.update(readings.of(normal_n, 0.4 * normal_n));
    slides = carried.detect_slide();
  }
  ASSERT_TRUE(slides);
  EXPECT_NEAR(*slides, 0.4, 0.03);
}

// Without noise, as one force vector gives them.
TEST(TractionRatioFilter, WithoutNoiseIsTheRatioOfEachFrame) {
  TractionRatioFilter carried(true);
  for (const double shear_n : {0.0, 0.5, 0.5, 0.6, 0.1}) {
    ContactPatch patch;
    patch.normal_n = 2;
    patch.shear_n = shear_n;
    carried.update(patch);
    EXPECT_EQ(carried.now().mean, shear_n / 2);
    EXPECT_EQ(carried.now().sigma, 0);
  }
}

}  // namespace
}  // namespace slipd
