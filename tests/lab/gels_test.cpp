// Gels under a contact move as elasticity says, and slides on them begin where they are said to.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lab/gels/measure.hpp"

namespace lab {
namespace {

using namespace slipd;

constexpr double kPictures_hz = 25;

class GelGrasps : public ::testing::Test {
 protected:
  const GelSurface surface_{GelFrames::kThickness_m, GelFrames::kPoisson};
  const TaxelLayout layout_ = TaxelLayout::grid(9, 7, 0.0018);
};

// Johnson, Contact Mechanics (1985), eq. 3.91a, with q = sqrt(1 - (r/a)^2) shear moduli.
TEST(GelSurface, ThatIsThickMovesLikeAHalfSpaceUnderADrag) {
  constexpr double kRadius_m = 0.002, kPoisson = 0.4;
  const GelSurface thick(0.05, kPoisson);
  const double scale_m = std::numbers::pi * kRadius_m / 32;
  for (const double place : {0.0, 0.5, 0.9}) {
    const double along = scale_m * (4 * (2 - kPoisson) - (4 - 3 * kPoisson) * place * place);
    const double across = scale_m * (4 * (2 - kPoisson) - (4 - kPoisson) * place * place);
    EXPECT_NEAR(thick.dragged(kRadius_m, place * kRadius_m, 0).along_m / along, 1, 0.04);
    EXPECT_NEAR(thick.dragged(kRadius_m, 0, place * kRadius_m).along_m / across, 1, 0.04);
    EXPECT_NEAR(thick.dragged(kRadius_m, place * kRadius_m, 0).across_m, 0, 1e-3 * along);
  }
}

TEST(GelSurface, ThatIsThinnerMovesLess) {
  const GelSurface thin(0.002, GelFrames::kPoisson), thick(0.006, GelFrames::kPoisson);
  EXPECT_LT(thin.dragged(0.003, 0, 0).along_m, 0.8 * thick.dragged(0.003, 0, 0).along_m);
}

TEST(GelSurface, KeepsItsVolumeByMovingOutOfThePressedPlace) {
  const GelSurface surface(GelFrames::kThickness_m, 0.49);
  EXPECT_GT(surface.pressed(0.003, 0.003), 0);
}

TEST_F(GelGrasps, HaveNoMarginFromTheSlideOnAndSomeBefore) {
  for (std::size_t i = 0; i < 10; ++i) {
    const RandomStream random = RandomStream(5).stream(i);
    const GelGrasp grasp = draw_gel_grasp(GelCourse::falls, random);
    GelFrames frames(grasp, surface_, layout_, kPictures_hz, 0, random);
    std::size_t sliding = 0;
    while (frames.next()) {
      const GraspMoment& at = frames.moment();
      if (at.normal_n <= 0) continue;
      const bool slides = at.time_s >= grasp.slides_s;
      EXPECT_EQ(at.truth.gamma < 1e-9, slides) << "at " << at.time_s << " s of " << grasp.slides_s;
      if (slides) ++sliding;
    }
    EXPECT_GE(sliding, 1U);
    EXPECT_GT(grasp.lost_s, grasp.slides_s);
  }
}

TEST_F(GelGrasps, BendTheGelUntilTheObjectIsLost) {
  const RandomStream random(6);
  const GelGrasp grasp = draw_gel_grasp(GelCourse::falls, random);
  GelFrames frames(grasp, surface_, layout_, kPictures_hz, 0, random);
  double held_m = 0, lost_m = 0;
  while (frames.next()) {
    const GelFrames::Moved middle = frames.moved(grasp.x_m, grasp.y_m);
    const double moved_m = std::hypot(middle.x_m, middle.y_m);
    if (frames.moment().time_s < grasp.slides_s) held_m = moved_m;
    if (frames.moment().time_s > grasp.lost_s) lost_m = moved_m;
  }
  EXPECT_GT(held_m, 1e-4);
  EXPECT_LT(lost_m, 1e-9);
}

TEST(MeasuredGels, TellObjectsThatAreLostAndNoneThatAreHeld) {
  const auto lines = measure_gels({.grasps = 12, .seed = 4, .threads = 1}, {});
  const GelLine& held = lines[static_cast<std::size_t>(GelCourse::held)];
  const GelLine& falls = lines[static_cast<std::size_t>(GelCourse::falls)];
  EXPECT_EQ(held.false_alerts, 0U);
  EXPECT_GT(held.held_s, 500);
  EXPECT_EQ(falls.told, 12U);
  EXPECT_GE(falls.soon_after_loss, 6U);
  EXPECT_LT(falls.after_s.median(), 0.3);
}

}  // namespace
}  // namespace lab
