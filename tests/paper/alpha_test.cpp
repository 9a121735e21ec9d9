#include "paper/dataset/alpha.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/numeric/random.hpp"
#include "core/simd/instruction_sets.hpp"
#include "paper/dataset/alpha_kernels.hpp"

namespace slipd {
namespace {

TEST(Alpha, IsTheAngleOfShearOverPressure) {
  constexpr std::size_t kCount = 4099;  // not a multiple of the number of lanes of a vector register
  std::vector<float> p(kCount), x(kCount), y(kCount), alpha(kCount);
  const RandomStream draws(3);
  for (std::size_t i = 0; i < kCount; ++i) {
    p[i] = static_cast<float>(std::exp(draws.uniform(4 * i, -10, 15)));
    x[i] = static_cast<float>(p[i] * std::sinh(draws.uniform(4 * i + 1, -9, 9)));
    y[i] = static_cast<float>(p[i] * draws.uniform(4 * i + 2, -3, 3));
  }
  const AlphaMask mask{.along_x = 0.6F, .along_y = -0.8F};
  alpha_of(p, x, y, mask, alpha);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double along = static_cast<double>(x[i] * 0.6F + y[i] * -0.8F);
    EXPECT_NEAR(alpha[i], std::atan2(along, static_cast<double>(p[i])), 1e-6)
        << x[i] << " " << y[i] << " " << p[i];
  }
}

// Alpha of a disc's taxels only, with the other sums of the same loop, on every instruction set.
TEST(Alpha, AndItsProjectionAreTheSameOnEveryInstructionSet) {
  constexpr std::size_t kCount = 1003, kRank = AlphaKernels::kTogether;
  constexpr float kUntouched = -7;
  std::vector<float> p(kCount), x(kCount), y(kCount), basis(kCount * kRank);
  const RandomStream draws(5);
  for (std::size_t i = 0; i < kCount; ++i) {
    p[i] = static_cast<float>(draws.uniform(3 * i, -100, 1000));
    x[i] = static_cast<float>(draws.uniform(3 * i + 1, -500, 900));
    y[i] = static_cast<float>(draws.uniform(3 * i + 2, -500, 900));
  }
  for (std::size_t i = 0; i < basis.size(); ++i) basis[i] = draws.stream(1).noise(i);
  const TaxelView view{p.data(), x.data(), y.data(), nullptr, nullptr, kCount};
  const AlphaMask mask{.least_pa = 50, .along_x = 0.6F, .along_y = 0.8F};
  const std::vector<slipd::TaxelRun> runs{{3, 4}, {10, 29}, {100, 164}, {500, 900}, {990, 1003}};
  for (const AlphaKernels* kernels : kernels_at_hand<AlphaKernels>()) {
    std::vector<float> alpha(kCount, kUntouched), point(kRank);
    const AngleSums sums = kernels->angles(view, runs, mask, alpha.data());
    double squares = 0, inverse = 0;
    std::size_t taken = 0;
    std::vector<double> wanted(kRank);
    for (const auto& run : runs) {
      for (std::size_t i = run.first; i < run.end; ++i) {
        const bool counts = p[i] > mask.least_pa;
        const double is = counts ? std::atan2(0.6 * x[i] + 0.8 * y[i], static_cast<double>(p[i])) : 0;
        EXPECT_NEAR(alpha[i], is, 1e-6) << kernels->name;
        squares += is * is;
        inverse += counts ? 1.0 / p[i] / p[i] : 0;
        taken += counts ? 1 : 0;
        for (std::size_t k = 0; k < kRank; ++k) wanted[k] += is * basis[i * kRank + k];
      }
    }
    EXPECT_EQ(alpha[2], kUntouched) << kernels->name;
    EXPECT_EQ(alpha[164], kUntouched) << kernels->name;
    EXPECT_NEAR(sums.squares, squares, 1e-5 * squares) << kernels->name;
    EXPECT_NEAR(sums.inverse_squares_per_pa2, inverse, 1e-5 * inverse) << kernels->name;
    EXPECT_EQ(sums.taken, taken) << kernels->name;
    kernels->project(alpha.data(), runs, basis.data(), kRank, point.data());
    // Tolerance: rounding in single precision of one term for each taxel.
    for (std::size_t k = 0; k < kRank; ++k) EXPECT_NEAR(point[k], wanted[k], 2e-4) << kernels->name;
  }
}

TEST(Alpha, KeepsTheDigitsOfASmallLoad) {
  const std::vector<float> ratio{0.0F, 1e-30F, 1e-6F, 1e-3F};
  std::vector<float> alpha(ratio.size());
  alpha_of_ratio(ratio, alpha);
  for (std::size_t i = 0; i < ratio.size(); ++i) EXPECT_NEAR(alpha[i], std::atan(ratio[i]), 1e-6F * ratio[i]);
}

TEST(Alpha, IsZeroWhereNothingPresses) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  const std::vector<float> p{0, -5, 10, 10.001F, nan, 100, 100, infinity},
      x{3, 3, 3, 3, 3, nan, infinity, infinity};
  const std::vector<float> y(p.size(), 0.0F);
  std::vector<float> alpha(p.size());
  alpha_of(p, x, y, {.least_pa = 10}, alpha);
  EXPECT_EQ(alpha[0], 0);
  EXPECT_EQ(alpha[1], 0);
  EXPECT_EQ(alpha[2], 0);  // at the threshold, not above it
  EXPECT_GT(alpha[3], 0);
  for (const float value : alpha) EXPECT_TRUE(std::isfinite(value));
}

}  // namespace
}  // namespace slipd
