// The filtered traction ratio of a sensor without shape: it follows the ratio closely, and its sigma covers
// its error.
#include "core/friction/traction_ratio.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
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
  TractionRatioFilter carried;
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
  TractionRatioFilter carried;
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
  TractionRatioFilter carried;
  Readings readings;
  for (int i = 0; i < 100; ++i) carried.update(readings.of(3, 0.3));
  carried.update(readings.of(3, 2.1));
  EXPECT_NEAR(carried.now().mean, 0.7, 3 * kNoiseN / 3);
}

TEST(TractionRatioFilter, NoiseInTheNormalForceIsNotTakenForSliding) {
  for (const double normal_n : {0.3, 0.5, 1.0, 3.0}) {
    TractionRatioFilter carried;
    Readings readings;
    for (int i = 0; i < 5000; ++i) {
      carried.update(readings.of(normal_n, 0.4 * normal_n));
      ASSERT_FALSE(carried.detect_slide()) << normal_n << " N, frame " << i;
    }
  }
}

// Load rises to `load` in 50 frames, then P falls for 150 while it stays.
std::optional<TractionRatioFilter::Slide> slide_of(double load, const SlidingVerdict& sliding) {
  TractionRatioFilter carried;
  Readings readings;
  std::optional<TractionRatioFilter::Slide> slide;
  for (int i = 0; i < 200 && !slide; ++i) {
    const double normal_n = i < 50 ? 3 : 3 - 0.01 * (i - 50);
    carried.update(readings.of(normal_n, load * std::min(1.0, i / 50.0) * normal_n));
    slide = carried.detect_slide(sliding);
  }
  return slide;
}

SlidingVerdict coherent(double coherence) {
  return {.sliding = Sliding::none, .for_s = 1, .field = {.known = true, .coherence = coherence, .block = 1}};
}

TEST(TractionRatioFilter, ARatioThatRoseAndIsEvenWhileTheGripFallsIsSliding) {
  const auto slide = slide_of(0.4, {});
  ASSERT_TRUE(slide);
  EXPECT_NEAR(slide->load, 0.4, 0.03);
}

TEST(TractionRatioFilter, ASlideOfTaxelsThatAreNotShearedOneWayIsNone) {
  EXPECT_TRUE(slide_of(0.4, coherent(0.95)));
  EXPECT_FALSE(slide_of(0.4, coherent(0.5)));
}

// Rubber and controller let P overshoot and relax while |Q|/P stays.
TEST(TractionRatioFilter, AGripThatOvershootsAndRelaxesDoesNotSlide) {
  for (const double load : {0.05, 0.1, 0.3}) {
    TractionRatioFilter carried;
    Readings readings;
    for (int i = 0; i < 1000; ++i) {
      const double normal_n = i < 50 ? 0.2 * (i + 1) : 4 + 6 * std::exp(-(i - 50) / 100.0);
      carried.update(readings.of(normal_n, load * normal_n));
      ASSERT_FALSE(carried.detect_slide()) << load << ", frame " << i;
    }
  }
}

TEST(TractionRatioFilter, ALoadThatTurnsWhileTheGripFallsDoesNotSlide) {
  for (const double turned_rad : {0.0, 1.0}) {
    TractionRatioFilter carried;
    bool slid = false;
    for (int i = 0; i < 200; ++i) {
      const double normal_n = i < 50 ? 3 : 3 - 0.01 * (i - 50), load = 0.4 * std::min(1.0, i / 50.0);
      const double angle = i < 50 ? 0 : turned_rad * (i - 50) / 20.0;
      ContactPatch patch;
      patch.normal_n = normal_n;
      patch.shear_n = load * normal_n;
      patch.shear_x_n = patch.shear_n * std::cos(angle);
      patch.shear_y_n = patch.shear_n * std::sin(angle);
      patch.normal_sigma_n = patch.shear_sigma_n = 0.001;
      carried.update(patch);
      slid = slid || carried.detect_slide();
    }
    EXPECT_EQ(slid, turned_rad == 0) << turned_rad << " rad";
  }
}

// Real slides scatter by 4 to 7 %, far more than a plateau may.
TEST(TractionRatioFilter, ASlideWhosePatternMovesIsReadOnceABlockHoweverItScatters) {
  TractionRatioFilter carried;
  std::mt19937 random(3);
  std::normal_distribution<double> scatter(0, 0.07);
  int readings = 0;
  double sum = 0, rough = 0;
  for (int i = 0; i < 500; ++i) {
    if (i % 10 == 0) rough = scatter(random);
    ContactPatch patch;
    patch.normal_n = 3;
    patch.shear_n = patch.shear_x_n = 0.4 * (1 + rough) * 3;
    patch.normal_sigma_n = patch.shear_sigma_n = 0.003;
    carried.update(patch);
    SlidingVerdict sliding = coherent(0.95);
    sliding.sliding = Sliding::translation;
    sliding.field.block = static_cast<std::uint32_t>(1 + i / 25);
    const auto slide = carried.detect_slide(sliding);
    if (!slide) continue;
    ++readings;
    sum += slide->load;
  }
  EXPECT_EQ(readings, 19);  // all blocks but the first
  EXPECT_NEAR(sum / readings, 0.4, 0.02);
}

// Without noise, as one force vector gives them.
TEST(TractionRatioFilter, WithoutNoiseIsTheRatioOfEachFrame) {
  TractionRatioFilter carried;
  for (const double shear_n : {0.0, 0.5, 0.5, 0.6, 0.1}) {
    ContactPatch patch;
    patch.normal_n = 2;
    patch.shear_n = shear_n;
    carried.update(patch);
    EXPECT_EQ(carried.now().mean, shear_n / 2);
    EXPECT_EQ(carried.now().sigma, 0);
    EXPECT_DOUBLE_EQ(carried.held().mean, shear_n / 2);  // a mean over frames would lag
  }
}

}  // namespace
}  // namespace slipd
