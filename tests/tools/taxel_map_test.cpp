#include "tools/slipctl/taxel_map.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/tools/samples.hpp"
#include "tools/slipctl/palette.hpp"

namespace slipctl::testing {
namespace {

TaxelFrame sample(int columns, int rows) {
  return frame_from(frame_sample(columns, rows));
}

TEST(Raster, HasYUpAndXToTheRight) {
  const TaxelFrame frame = sample(2, 2);  // rows from y small to large, x fastest
  const Raster raster = rasterise(frame, std::vector<double>{1, 2, 3, 4}, 2, 2);
  EXPECT_EQ(raster.at(0, 0), 3);
  EXPECT_EQ(raster.at(1, 0), 4);
  EXPECT_EQ(raster.at(0, 1), 1);
  EXPECT_EQ(raster.at(1, 1), 2);
}

TEST(Raster, KeepsTheMeanWhenTaxelsShareAPixel) {
  const TaxelFrame frame = sample(100, 100);
  std::vector<double> values(10000);
  std::iota(values.begin(), values.end(), 0.0);
  const Raster raster = rasterise(frame, values, 25, 20);
  double sum = 0;
  for (const auto& value : raster.values) sum += value.value();
  EXPECT_NEAR(sum / 500, 9999 / 2.0, 1e-9 * 9999);  // rounding of 10000 sums
}

TEST(Raster, LeavesNoHoleInAGridHoweverFineThePixels) {
  for (const int taxels : {1, 2, 3, 4, 7, 16, 100})
    for (const int pixels : {1, 2, 5, 13, 26, 64}) {
      const TaxelFrame frame = sample(taxels, taxels);
      const Raster raster = rasterise(frame, frame.normal_pa, pixels, pixels);
      for (const auto& value : raster.values)
        EXPECT_TRUE(value) << taxels << " taxels, " << pixels << " pixels";
    }
}

TEST(Raster, LeavesPixelsEmptyWhereNoTaxelLies) {
  TaxelFrame corners = sample(2, 2);
  corners.x_mm = {0, 1, 0, 9};
  corners.y_mm = {0, 0, 1, 9};
  const Raster raster = rasterise(corners, std::vector<double>{1, 1, 1, 1}, 10, 10);
  EXPECT_TRUE(raster.at(0, 9));
  EXPECT_TRUE(raster.at(9, 0));
  EXPECT_FALSE(raster.at(5, 5));
}

TEST(Map, IsTwiceAsWideInCharactersAsHighForASquare) {
  EXPECT_EQ(map_size(sample(32, 32), 10, 80).columns, 20);
}

TEST(Map, KeepsTheLayoutsShapeAlsoAtItsLimit) {
  EXPECT_EQ(map_size(sample(8, 4), 10, 80).columns, 40);
  EXPECT_EQ(map_size(sample(8, 4), 10, 80).rows, 10);
  EXPECT_EQ(map_size(sample(8, 4), 10, 30).columns, 30);
  EXPECT_EQ(map_size(sample(8, 4), 10, 30).rows, 8);     // 7.5
  EXPECT_EQ(map_size(sample(32, 32), 16, 25).rows, 12);  // 24 columns
}

TEST(Map, HasDarkArrowsOnBrightColoursAndBrightOnesOnDark) {
  EXPECT_EQ(readable_on(traction_colour(1)), kBlack);
  EXPECT_EQ(readable_on(traction_colour(0)), kWhite);
}

TEST(Map, ShowsArrowsAlongTheShear) {
  Canvas canvas(20, 10);
  draw_shear(canvas, {0, 0, 20, 10}, sample(32, 32), 50e3, 0.5, ColourDepth::rgb);
  EXPECT_NE(canvas.to_text().find("→ → →"), std::string::npos);
  EXPECT_EQ(canvas.to_text().find("←"), std::string::npos);
}

TEST(Map, ShowsPressureWithoutColoursAsShades) {
  Canvas canvas(20, 10);
  draw_pressure(canvas, {0, 0, 20, 10}, sample(32, 32), 50e3, ColourDepth::none);
  EXPECT_NE(canvas.row_text(5).find("▓█"), std::string::npos);
  EXPECT_EQ(canvas.row_text(0), "····················");
}

}  // namespace
}  // namespace slipctl::testing
