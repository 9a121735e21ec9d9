#include "paper/dataset/fold.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace slipd {
namespace {

TEST(Fold, AnOrbitsTaxelsAreEquallyFarFromTheMiddle) {
  for (const std::size_t side : {1U, 4U, 7U, 16U}) {
    const auto layout = TaxelLayout::grid(side, side, 1e-3);
    const auto folded = fold(layout);
    ASSERT_TRUE(folded);
    const std::size_t half = (side + 1) / 2;
    EXPECT_EQ(folded->representative.size(), half * (half + 1) / 2);
    for (std::size_t i = 0; i < layout.size(); ++i) {
      const std::size_t other = folded->representative[folded->orbit[i]];
      EXPECT_NEAR(std::hypot(layout.x_m()[i], layout.y_m()[i]),
                  std::hypot(layout.x_m()[other], layout.y_m()[other]), 1e-15);
    }
    float taxels = 0;
    for (const float w : folded->weight) taxels += w * w;
    EXPECT_NEAR(taxels, static_cast<float>(layout.size()), 1e-3F);
  }
}

TEST(Fold, UnfoldingKeepsABasisOrthonormal) {
  const auto folded = fold(TaxelLayout::grid(6, 6, 1e-3));
  const Eigen::MatrixXf small = Eigen::MatrixXf::Identity(6, 6);
  const Eigen::MatrixXf large = folded->unfold(small);
  EXPECT_LT((large.transpose() * large - small).cwiseAbs().maxCoeff(), 1e-6F);
}

TEST(Fold, OnlySquareGridsHaveOne) {
  EXPECT_FALSE(fold(TaxelLayout::grid(4, 5, 1e-3)));
  EXPECT_FALSE(fold(TaxelLayout::scattered({0, 1e-3, 2e-3}, {0, 0, 0})));
}

}  // namespace
}  // namespace slipd
