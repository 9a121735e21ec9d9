#include "core/contact/subsurface/point_load.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

namespace slipd::contact {
namespace {

// Boussinesq (1885) and Cerruti (1882): the stresses on a plane at depth z of a unit point load, as Johnson
// (1985), (3.19) and (3.75) to (3.77), gives them.
SensedTensor stresses(double x, double y, double z) {
  const double r = std::sqrt(x * x + y * y + z * z), all = 3 / (2 * std::numbers::pi * std::pow(r, 5));
  return {all * z * z * z, all * x * z * z, all * y * z * z,
          all * x * x * z, all * x * y * z, all * y * y * z};
}

// Midpoints of 400 x 400 parts.
SensedTensor by_quadrature(const Rectangle& of, double z) {
  constexpr int kParts = 400;
  const double dx = (of.right_m - of.left_m) / kParts, dy = (of.top_m - of.bottom_m) / kParts;
  SensedTensor sum;
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; j < kParts; ++j) {
      const SensedTensor at = stresses(of.left_m + (i + 0.5) * dx, of.bottom_m + (j + 0.5) * dy, z);
      sum.nn += at.nn * dx * dy;
      sum.nx += at.nx * dx * dy;
      sum.ny += at.ny * dx * dy;
      sum.xx += at.xx * dx * dy;
      sum.xy += at.xy * dx * dy;
      sum.yy += at.yy * dx * dy;
    }
  }
  return sum;
}

TEST(PointLoads, InARectangleAreTheIntegralsOfTheStressesOfBoussinesqAndCerruti) {
  constexpr Rectangle kRectangles[] = {
      {-0.0023, 0.0023, -0.0023, 0.0023}, {0.001, 0.005, -0.004, 0.0005}, {-0.009, -0.004, 0.002, 0.006}};
  for (const Rectangle& of : kRectangles) {
    for (const double depth_m : {0.001, 0.003}) {
      const SensedTensor exact = sensed_in_rectangle(of, depth_m), sum = by_quadrature(of, depth_m);
      constexpr double kMidpoints = 2e-5;  // (part/depth)^2/24, and few parts more
      EXPECT_NEAR(exact.nn, sum.nn, kMidpoints);
      EXPECT_NEAR(exact.nx, sum.nx, kMidpoints);
      EXPECT_NEAR(exact.ny, sum.ny, kMidpoints);
      EXPECT_NEAR(exact.xx, sum.xx, kMidpoints);
      EXPECT_NEAR(exact.xy, sum.xy, kMidpoints);
      EXPECT_NEAR(exact.yy, sum.yy, kMidpoints);
    }
  }
}

TEST(PointLoads, AreReadInAllByAWholePlane) {
  constexpr Rectangle kPlane{-30, 30, -30, 30};
  const SensedTensor half_space = sensed_in_rectangle(kPlane, 0.001);
  EXPECT_NEAR(half_space.nn, 1, 1e-4);
  EXPECT_NEAR(half_space.xx, 1, 1e-4);
  EXPECT_NEAR(half_space.yy, 1, 1e-4);
  EXPECT_NEAR(half_space.nx, 0, 1e-12);
  EXPECT_NEAR(half_space.xy, 0, 1e-12);
  // The images of a layer are least squares, and hold to some thousandths.
  const auto images = layer_images(0.45);
  const LayerTensor layer = sensed_in_rectangle(kPlane, 0.001, std::span(images));
  EXPECT_NEAR(layer.nn, 1, 0.01);
  EXPECT_NEAR(layer.xx, 1, 0.01);
  EXPECT_NEAR(layer.yy, 1, 0.01);
}

// 16 taxels of 4.7 mm under 1 mm.
TEST(PointLoads, LeaveASixthOfAPullBeyondAPad) {
  const SensedTensor pad = sensed_in_rectangle({-0.0094, 0.0094, -0.0094, 0.0094}, 0.001);
  EXPECT_GT(pad.nn, 0.99);
  EXPECT_LT(pad.xx, 0.9);
  EXPECT_GT(pad.xx, 0.8);
}

}  // namespace
}  // namespace slipd::contact
