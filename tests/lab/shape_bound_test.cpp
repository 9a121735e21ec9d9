// The bounds beside which contacts under a skin and of other shapes are measured.
#include "lab/tradeoff/shape_bound.hpp"

#include <gtest/gtest.h>

#include "core/contact/contact_field.hpp"
#include "core/frame/layout.hpp"
#include "core/reading/fit/normal_equations/contact_shape.hpp"

namespace lab {
namespace {

using slipd::TaxelLayout;

const TaxelLayout kLayout = TaxelLayout::grid(32, 32, 0.5e-3);

double bound_by_closing(double depth_m, double power, double noise_share = 0.01) {
  const auto pair = slipd::contact::make_body_pair({0.01, 0.5e6, 0.45}, {0.02, 2e11, 0.25});
  const KnownContact truth{
      .x_m = 0.4e-3, .y_m = -0.3e-3, .ellipse = {3e-3, 3e-3, 0}, .load = 0.2, .gamma = 0.5, .pull_rad = 0.7};
  slipd::contact::ContactField sheet(kLayout, {.depth_m = depth_m, .power = power});
  return cramer_rao_sigma_by_closing(sheet, kLayout.size(), pair, 2, truth, noise_share);
}

TEST(BoundByClosing, IsNearThatOfAKnownShapeForASphere) {
  const auto pair = slipd::contact::make_body_pair({0.01, 0.5e6, 0.45}, {0.02, 2e11, 0.25});
  const double a_m = pair.contact_radius_m(2);
  for (const double depth_m : {0.0, 1e-3}) {
    slipd::ContactShape model(kLayout, depth_m, {});
    const KnownContact truth{
        .x_m = 0.4e-3, .y_m = -0.3e-3, .ellipse = {a_m, a_m, 0}, .load = 0.2, .gamma = 0.5, .pull_rad = 0.7};
    const double of_shape = cramer_rao_sigma(model, truth, 0.01), by_closing = bound_by_closing(depth_m, 2);
    EXPECT_NEAR(by_closing / of_shape, 1, 0.15) << depth_m;
  }
}

TEST(BoundByClosing, GrowsWithNoiseWithDepthAndForFlatterContacts) {
  const double one = bound_by_closing(0, 2);
  EXPECT_NEAR(bound_by_closing(0, 2, 0.03) / one, 3, 1e-6);
  EXPECT_GT(bound_by_closing(1e-3, 2), 2 * one);
  EXPECT_GT(bound_by_closing(0, 6), 1.2 * one);
}

}  // namespace
}  // namespace lab
