// The data sets: the values of the columns, which do not depend on how many are asked for at once.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/contact/cattaneo_mindlin.hpp"
#include "core/contact/scene_draws.hpp"
#include "paper/basis/svd.hpp"
#include "paper/dataset/frame_columns.hpp"
#include "paper/dataset/paper_columns.hpp"

namespace slipd {
namespace {

Scene paper_scene(double noise = 0, double offset_m = 0) {
  Scene scene;
  scene.objects = paper_objects();
  scene.noise = noise;
  scene.offset_m = offset_m;
  return scene;
}

TaxelLayout paper_layout(std::size_t side) {
  return TaxelLayout::grid(side, side, 0.0144 / static_cast<double>(side));
}

constexpr DataSetSize kSmall{.contacts = 12, .loads = 5};

TEST(DrawnContacts, LieInTheScenesRangesInTheScenesShares) {
  const Scene scene = paper_scene(0, 0.002);
  int stiff = 0, flat = 0;
  constexpr int kCount = 4000;
  for (std::size_t i = 0; i < kCount; ++i) {
    const ContactDraw draw = draw_contact(scene, 1, i);
    stiff += draw.modulus_pa > 1e9 ? 1 : 0;
    flat += std::isinf(draw.radius_m) ? 1 : 0;
    EXPECT_TRUE(draw.normal_n >= 1 && draw.normal_n <= 5);
    EXPECT_TRUE(draw.friction >= 0.1 && draw.friction <= 0.9);
    EXPECT_TRUE(std::isinf(draw.radius_m) || (draw.radius_m >= 0.01 && draw.radius_m <= 0.05));
    EXPECT_TRUE(std::abs(draw.x_m) <= 0.002 && std::abs(draw.y_m) <= 0.002);
  }
  // Half of each, within five standard errors.
  EXPECT_NEAR(stiff, kCount / 2, 5 * std::sqrt(kCount / 4.0));
  EXPECT_NEAR(flat, kCount / 2, 5 * std::sqrt(kCount / 4.0));
}

TEST(DrawnContacts, NeedObjects) {
  EXPECT_THROW(draw_contact(Scene{}, 1, 0), std::invalid_argument);
}

TEST(PaperColumns, AreTheContactModelAtEachTaxel) {
  const auto layout = paper_layout(20);
  const Scene scene = paper_scene(0, 0.001);
  for (const auto quantity : {Quantity::pressure, Quantity::shear, Quantity::alpha}) {
    const PaperColumns columns(TaxelSet(layout), scene, kSmall, 5, quantity);
    std::vector<float> values(layout.size());
    for (std::size_t j = 0; j < columns.columns(); j += 7) {
      columns.fill(j, 1, values.data());
      const ContactDraw draw = draw_contact(scene, 5, columns.contact(j));
      const auto pair = contact::make_body_pair(contact::body_of(scene.skin),
                                                {draw.radius_m, draw.modulus_pa, draw.poisson});
      const contact::CattaneoMindlin load(pair, draw.normal_n, draw.friction, 1 - columns.gamma(j));
      for (std::size_t i = 0; i < layout.size(); ++i) {
        const auto there = load.at(std::hypot(layout.x_m()[i] - draw.x_m, layout.y_m()[i] - draw.y_m) /
                                   load.contact_radius_m());
        const double expected = quantity == Quantity::pressure ? there.pressure_pa
                                : quantity == Quantity::shear  ? there.shear_pa
                                                               : there.angle_rad;
        EXPECT_NEAR(values[i], expected, 1e-6 * std::max(1.0, expected));
      }
    }
  }
}

TEST(PaperColumns, NoiseStaysWithinItsShareOfTheLargestValue) {
  const auto layout = paper_layout(20);
  const PaperColumns clean(TaxelSet(layout), paper_scene(), kSmall, 5, Quantity::alpha);
  const PaperColumns noisy(TaxelSet(layout), paper_scene(0.1), kSmall, 5, Quantity::alpha);
  std::vector<float> a(layout.size()), b(layout.size());
  for (std::size_t j = 0; j < clean.columns(); ++j) {
    clean.fill(j, 1, a.data());
    noisy.fill(j, 1, b.data());
    const float width = 0.1F * *std::max_element(a.begin(), a.end());
    float largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
    EXPECT_LE(largest, width * 1.00001F);
    EXPECT_GE(largest, width * 0.9F);
  }
}

TEST(Columns, AreTheSameAloneAndInABlock) {
  const TaxelSet taxels(paper_layout(12));
  const PaperColumns paper(taxels, paper_scene(0.05, 0.002), kSmall, 9, Quantity::alpha);
  const FrameColumns frames(taxels, paper_scene(0.05, 0.002), 9, {.size = kSmall});
  for (const ColumnSource* source :
       {static_cast<const ColumnSource*>(&paper), static_cast<const ColumnSource*>(&frames)}) {
    std::vector<float> all(source->rows() * source->columns()), one(source->rows());
    source->fill(0, source->columns(), all.data());
    for (std::size_t j = 0; j < source->columns(); ++j) {
      source->fill(j, 1, one.data());
      EXPECT_TRUE(
          std::equal(one.begin(), one.end(), all.begin() + static_cast<std::ptrdiff_t>(j * source->rows())));
    }
  }
}

// A symmetric matrix and its fold (one eighth of the rows) have the same sums of singular values and the
// same bases.
template <typename Folded, typename Whole>
void expect_same_decomposition(const Folded& folded, const Whole& whole, const Fold& fold) {
  const Svd small = randomized_svd(folded, {.rank = 6}), large = randomized_svd(whole, {.rank = 6});
  EXPECT_NEAR(small.total_variance / large.total_variance, 1, 1e-5);
  const Eigen::MatrixXf spread = fold.unfold(small.basis);
  for (Eigen::Index i = 0; i < 6; ++i) {
    EXPECT_NEAR(small.singular_values[i] / large.singular_values[i], 1, 1e-4);
    EXPECT_NEAR(std::abs(spread.col(i).dot(large.basis.col(i))), 1, 1e-3);
  }
}

TEST(SymmetryFold, GivesTheDecompositionOfTheWholeMatrix) {
  const auto layout = paper_layout(21);
  const auto folded = fold(layout);
  const DataSetSize size{.contacts = 40, .loads = 10};
  expect_same_decomposition(PaperColumns(TaxelSet(layout, *folded), paper_scene(), size, 2, Quantity::alpha),
                            PaperColumns(TaxelSet(layout), paper_scene(), size, 2, Quantity::alpha), *folded);
  expect_same_decomposition(FrameColumns(TaxelSet(layout, *folded), paper_scene(), 2, {.size = size}),
                            FrameColumns(TaxelSet(layout), paper_scene(), 2, {.size = size}), *folded);
}

TEST(SymmetryFold, RefusesWhatIsNotSymmetric) {
  const auto layout = paper_layout(8);
  const TaxelSet taxels(layout, *fold(layout));
  EXPECT_THROW(PaperColumns(taxels, paper_scene(0.01), kSmall, 1, Quantity::alpha), std::invalid_argument);
  EXPECT_THROW(FrameColumns(taxels, paper_scene(0, 0.001), 1, {.size = kSmall}), std::invalid_argument);
}

}  // namespace
}  // namespace slipd
