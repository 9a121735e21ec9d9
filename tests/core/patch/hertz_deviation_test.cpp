// Measures of a contact's shape from its pressure, compared with shapes in closed form.
#include "core/patch/hertz_deviation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

constexpr double kRadiusM = 5e-3, kPeakPa = 1e5;

// A frame of a pad of 100 x 100 taxels, 16 mm wide, with `pressure` (relative to the peak) as a function of
// position in units of the radius.
template <typename Pressure>
HertzDeviation of(Pressure pressure, double noise = 0) {
  const auto layout = TaxelLayout::grid(100, 100, 0.00016);
  std::mt19937 random(3);
  std::normal_distribution<double> deviation(0, 1);
  std::vector<float> normal, shear(layout.size(), 0.0F);
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const double x = layout.x_m()[i] / kRadiusM, y = layout.y_m()[i] / kRadiusM;
    normal.push_back(static_cast<float>(kPeakPa * (pressure(x, y) + noise * deviation(random))));
  }
  PatchFinder finder(layout);
  const ContactPatch& patch = finder.find({1, 1, normal, shear, shear});
  return hertz_deviation(best_kernels<DiscKernels>().moments(patch.taxels, patch.runs, patch.pose()), patch,
                         layout.side_m());
}

double hertz(double x, double y) {
  return std::sqrt(std::max(0.0, 1 - x * x - y * y));
}

TEST(HertzDeviation, ARoundContactIsHertzsWithNoiseAndWithout) {
  for (const double noise : {0.0, 0.005, 0.03}) {
    const HertzDeviation got = of(hertz, noise);
    EXPECT_EQ(got.tilt, 0) << noise;
    EXPECT_EQ(got.ellipticity, 0) << noise;
    EXPECT_EQ(got.excess_kurtosis, 0) << noise;
    EXPECT_TRUE(got.hertzian());
    EXPECT_EQ(got.sigma(), 0);
  }
}

TEST(HertzDeviation, ReadsHowFarAContactIsTilted) {
  for (const double tilt : {0.05, 0.2, 0.4}) {
    for (const double turn : {0.0, 0.7, 2.0}) {
      const HertzDeviation got = of([&](double x, double y) {
        return hertz(x, y) * (1 + tilt * (x * std::cos(turn) + y * std::sin(turn)));
      });
      EXPECT_NEAR(got.tilt / tilt, 1, 0.1) << tilt << ", turned by " << turn;
      EXPECT_TRUE(got.hertzian());
    }
  }
}

TEST(HertzDeviation, ReadsHowLongAContactIsAndDoesNotTakeThatForASkin) {
  for (const double axes : {1.1, 1.25, 1.5, 2.0}) {
    const HertzDeviation got =
        of([&](double x, double y) { return hertz(x / std::sqrt(axes), y * std::sqrt(axes)); }, 0.003);
    const double square = axes * axes;
    // The evaluated disc is round, so it misses the ends of a long contact.
    EXPECT_NEAR(got.ellipticity / ((square - 1) / (square + 1)), 1, axes < 1.4 ? 0.05 : 0.15) << axes;
    EXPECT_LT(got.excess_kurtosis, 0.05) << axes;
    EXPECT_EQ(got.hertzian(), axes < 1.7) << axes;
  }
}

// The contact's pressure plus a lower one that reaches 1.4 times as far, as under a skin.
TEST(HertzDeviation, ReadsPressureThatLiesFartherOut) {
  double before = 0;
  for (const double share : {0.05, 0.1, 0.2, 0.4}) {
    const HertzDeviation got =
        of([&](double x, double y) { return hertz(x, y) + 0.5 * share * hertz(0.7 * x, 0.7 * y); });
    EXPECT_GT(got.excess_kurtosis, before) << share;
    EXPECT_EQ(got.tilt, 0) << share;
    EXPECT_EQ(got.ellipticity, 0) << share;
    EXPECT_GE(got.sigma(), got.excess_kurtosis) << share;
    before = got.excess_kurtosis;
  }
}

}  // namespace
}  // namespace slipd
