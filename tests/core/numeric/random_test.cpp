#include "core/numeric/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slipd {
namespace {

TEST(RandomStream, AreTheSameOnEveryMachine) {
  // Recorded once. If these numbers change, every model and every figure changes.
  EXPECT_EQ(RandomStream(1).bits(0), 6791897765849424158ULL);
  EXPECT_EQ(RandomStream(1).stream(5).bits(7), 11349061025129719534ULL);
}

TEST(RandomStream, AreUniformAndIndependentOfTheirNeighbours) {
  const RandomStream draws = RandomStream(42).stream(3);
  constexpr int kCount = 100000;
  double sum = 0, squares = 0, product = 0;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const double u = draws.uniform(i);
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    sum += u;
    squares += u * u;
    product += (u - 0.5) * (RandomStream(42).stream(4).uniform(i) - 0.5);
  }
  // Five standard errors of 100000 draws.
  EXPECT_NEAR(sum / kCount, 0.5, 5 * std::sqrt(1.0 / 12 / kCount));
  EXPECT_NEAR(squares / kCount, 1.0 / 3, 5 * std::sqrt(4.0 / 45 / kCount));
  EXPECT_NEAR(product / kCount, 0, 5 / 12.0 / std::sqrt(kCount));
}

TEST(RandomStream, NoiseAddedInBulkIsTheNoiseOfEachPlace) {
  for (const std::uint64_t n : {1U, 2U, 9U}) {
    std::vector<float> values(n, 0.0F);
    RandomStream(8).add_noise(values.data(), n, 1);
    for (std::uint64_t i = 0; i < n; ++i) {
      EXPECT_EQ(values[i], RandomStream(8).noise(i));
      EXPECT_LE(std::abs(values[i]), 1.0F);
    }
  }
}

}  // namespace
}  // namespace slipd
