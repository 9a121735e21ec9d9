#include "core/frame/layout.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <stdexcept>

namespace slipd {
namespace {

TEST(TaxelLayout, AGridIsCentredWithXFastestAndYRising) {
  const auto grid = TaxelLayout::grid(3, 2, 0.002);
  ASSERT_EQ(grid.size(), 6U);
  EXPECT_DOUBLE_EQ(grid.x_m()[0], -0.002);
  EXPECT_DOUBLE_EQ(grid.x_m()[1], 0);
  EXPECT_DOUBLE_EQ(grid.y_m()[0], -0.001);
  EXPECT_DOUBLE_EQ(grid.y_m()[3], 0.001);
  EXPECT_DOUBLE_EQ(std::accumulate(grid.x_m().begin(), grid.x_m().end(), 0.0), 0);
  EXPECT_EQ(grid.regular()->columns, 3U);
}

TEST(TaxelLayout, ScatteredTaxelsAreAsWideAsTheirNeighboursAreFar) {
  const auto grid = TaxelLayout::grid(5, 4, 0.003);
  const auto same =
      TaxelLayout::scattered({grid.x_m().begin(), grid.x_m().end()}, {grid.y_m().begin(), grid.y_m().end()});
  EXPECT_NEAR(same.side_m(), 0.003, 1e-15);
  EXPECT_FALSE(same.regular().has_value());
}

TEST(TaxelLayout, InvalidLayoutsAreRefused) {
  EXPECT_THROW(TaxelLayout::grid(0, 4, 0.001), std::invalid_argument);
  EXPECT_THROW(TaxelLayout::grid(4, 5000, 0.001), std::invalid_argument);
  EXPECT_THROW(TaxelLayout::grid(4, 4, 0), std::invalid_argument);
  EXPECT_THROW(TaxelLayout::grid(4, 4, std::nan("")), std::invalid_argument);
  EXPECT_THROW(TaxelLayout::scattered({}, {}), std::invalid_argument);
  EXPECT_THROW(TaxelLayout::scattered({0, 0}, {1, 1}), std::invalid_argument);
  EXPECT_THROW(TaxelLayout::scattered({0, std::nan("")}, {1, 2}), std::invalid_argument);
  EXPECT_THROW(TaxelLayout::wrench(-1), std::invalid_argument);
}

}  // namespace
}  // namespace slipd
