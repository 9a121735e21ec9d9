#include "core/model/alpha.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/model/random.hpp"

namespace slipd {
namespace {

TEST(Alpha, IsTheAngleOfShearOverPressure) {
  constexpr std::size_t kCount = 4099;  // no multiple of a vector register's lanes
  std::vector<float> p(kCount), x(kCount), y(kCount), alpha(kCount);
  const Draws draws(3);
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
