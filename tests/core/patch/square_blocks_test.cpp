#include "core/patch/square_blocks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/heap_count.hpp"

namespace slipd {
namespace {

// A frame whose channels are linear in place: the mean over any block is the value at its middle.
struct LinearFrame {
  explicit LinearFrame(const TaxelLayout& layout)
      : normal(layout.size()),
        x(layout.size()),
        y(layout.size()),
        x_m(layout.x_m().begin(), layout.x_m().end()),
        y_m(layout.y_m().begin(), layout.y_m().end()) {
    for (std::size_t i = 0; i < layout.size(); ++i) {
      normal[i] = static_cast<float>(normal_at(layout.x_m()[i], layout.y_m()[i]));
      x[i] = static_cast<float>(shear_x_at(layout.x_m()[i]));
      y[i] = static_cast<float>(shear_y_at(layout.y_m()[i]));
    }
  }
  static double normal_at(double x_m, double y_m) { return 2000 + 1e5 * x_m - 3e4 * y_m; }
  static double shear_x_at(double x_m) { return 500 - 4e4 * x_m; }
  static double shear_y_at(double y_m) { return 100 + 2e4 * y_m; }

  ContactPatch patch(double center_x_m, double center_y_m, double radius_m) const {
    ContactPatch out;
    out.in_contact = true;
    out.center_x_m = center_x_m;
    out.center_y_m = center_y_m;
    out.radius_m = radius_m;
    out.direction_x = 0.6;
    out.direction_y = 0.8;
    out.taxels = {normal.data(), x.data(), y.data(), x_m.data(), y_m.data(), normal.size()};
    return out;
  }
  std::vector<float> normal, x, y, x_m, y_m;
};

constexpr double kPitch = 1e-4;

TEST(SquareBlocks, AreTheMeansOfTheirTaxelsWhereverTheContactLies) {
  const TaxelLayout layout = TaxelLayout::grid(70, 47, kPitch);
  const LinearFrame frame(layout);
  SquareBlocks blocks(layout, 4);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 500; ++i) {
    const double radius = kPitch * (2 + 18 * std::fabs(unit(random)));
    const ContactPatch patch = frame.patch(35 * kPitch * unit(random), 23 * kPitch * unit(random), radius);
    blocks.sum(patch, 4);
    ASSERT_GT(blocks.size(), 0U);
    ASSERT_LE(blocks.size(), blocks.most_along() * blocks.most_along());
    std::size_t at = 0;
    for (std::size_t row = 0; row < blocks.rows().size(); ++row) {
      for (std::uint32_t column = blocks.rows()[row].first; column < blocks.rows()[row].end; ++column, ++at) {
        const double x = blocks.x_m()[at] + patch.center_x_m, y = blocks.y_m()[at] + patch.center_y_m;
        EXPECT_NEAR(blocks.normal_pa()[at], LinearFrame::normal_at(x, y), 0.01);
        EXPECT_NEAR(blocks.shear_pa()[at],
                    0.6 * LinearFrame::shear_x_at(x) + 0.8 * LinearFrame::shear_y_at(y), 0.01);
        EXPECT_NEAR(blocks.x_m()[at], blocks.left_m() + blocks.side_m() * (column + 0.5), 1e-12);
        EXPECT_NEAR(blocks.y_m()[at], blocks.bottom_m() + blocks.side_m() * (static_cast<double>(row) + 0.5),
                    1e-12);
      }
    }
    EXPECT_EQ(at, blocks.size());
  }
}

TEST(SquareBlocks, CoverAContactAwayFromTheEdges) {
  const TaxelLayout layout = TaxelLayout::grid(100, 100, kPitch);
  const LinearFrame frame(layout);
  SquareBlocks blocks(layout, 4);
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 300; ++i) {
    const double radius = kPitch * (3 + 22 * std::fabs(unit(random)));
    const ContactPatch patch = frame.patch(10 * kPitch * unit(random), 10 * kPitch * unit(random), radius);
    blocks.sum(patch, 4);
    // A point of the rim lies in a block, whatever its direction.
    for (double angle = 0; angle < 6.28; angle += 0.05) {
      const auto column = static_cast<std::int64_t>(
          std::floor((radius * std::cos(angle) - blocks.left_m()) / blocks.side_m()));
      const auto row = static_cast<std::int64_t>(
          std::floor((radius * std::sin(angle) - blocks.bottom_m()) / blocks.side_m()));
      ASSERT_GE(row, 0);
      ASSERT_LT(row, static_cast<std::int64_t>(blocks.rows().size()));
      const TaxelRun& run = blocks.rows()[static_cast<std::size_t>(row)];
      EXPECT_GE(column, run.first);
      EXPECT_LT(column, run.end);
    }
  }
}

TEST(SquareBlocks, GrowWithTheContactAndNeverBeyondAShareOfIt) {
  const TaxelLayout layout = TaxelLayout::grid(100, 100, kPitch);
  const LinearFrame frame(layout);
  SquareBlocks blocks(layout, 5);
  std::size_t last = 1;
  for (double taxels = 1; taxels < 40; taxels += 0.5) {
    blocks.sum(frame.patch(0, 0, taxels * kPitch), 5);
    EXPECT_GE(blocks.taxels_along(), last);
    last = blocks.taxels_along();
    if (last > 1) {
      EXPECT_GE(taxels * kPitch / blocks.side_m(), 5 - 1e-9);
    }
  }
  EXPECT_EQ(last, 7U);
}

TEST(SquareBlocks, AllocateNothing) {
  const TaxelLayout layout = TaxelLayout::grid(64, 80, kPitch);
  const LinearFrame frame(layout);
  SquareBlocks blocks(layout, 4);
  const auto before = test::allocations();
  for (double taxels = 0.5; taxels < 200; taxels *= 1.05) {
    blocks.sum(frame.patch(0, 0, taxels * kPitch), 4);
    blocks.sum(frame.patch(40 * kPitch, -45 * kPitch, taxels * kPitch), 4);
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace slipd
