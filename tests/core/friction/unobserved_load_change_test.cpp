// The sigma that is added for forces that moved between two frames.
#include "core/friction/unobserved_load_change.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace slipd {
namespace {

constexpr double kMovedFriction = 0.5;

ContactPatch patch(double normal_n, double shear_x_n, double shear_y_n = 0) {
  ContactPatch made;
  made.in_contact = true;
  made.normal_n = normal_n;
  made.shear_x_n = shear_x_n;
  made.shear_y_n = shear_y_n;
  made.shear_n = std::hypot(shear_x_n, shear_y_n);
  made.normal_sigma_n = made.shear_sigma_n = 0.002;
  return made;
}

TEST(UnobservedLoadChange, OfFramesThatFollowOneAnotherCloselyIsNone) {
  UnobservedLoadChange unseen;
  unseen.update(patch(0.05, 0), kMovedFriction);
  for (int i = 1; i <= 200; ++i) {
    unseen.update(patch(2, 0.004 * i), kMovedFriction);
    if (i == 1) unseen.reset();  // the grip itself is not counted as motion
  }
  EXPECT_EQ(unseen.sigma(), 0);
}

TEST(UnobservedLoadChange, IsNoneInTheFirstFrameWithAnyForces) {
  UnobservedLoadChange unseen;
  unseen.update(patch(5, 2), kMovedFriction);
  EXPECT_EQ(unseen.sigma(), 0);
}

TEST(UnobservedLoadChange, GrowsWithTheShareOfTheForceThatMovedAlsoAcross) {
  for (const auto& [next, share] :
       {std::pair(patch(1, 0), 1.0), std::pair(patch(2, 0.4), 0.4), std::pair(patch(2, 0, 0.4), 0.4)}) {
    UnobservedLoadChange unseen;
    unseen.update(patch(2, 0), kMovedFriction);
    unseen.update(next, kMovedFriction);
    EXPECT_NEAR(unseen.sigma(), UnobservedLoadChange::kSigmaOfMotion * share, 0.002);
  }
}

TEST(UnobservedLoadChange, OfNoiseIsNone) {
  ContactPatch first = patch(1, 0), second = patch(1.2, 0.1);
  first.normal_sigma_n = first.shear_sigma_n = second.normal_sigma_n = second.shear_sigma_n = 0.05;
  UnobservedLoadChange unseen;
  unseen.update(first, kMovedFriction);
  unseen.update(second, kMovedFriction);
  EXPECT_EQ(unseen.sigma(), 0);
}

TEST(UnobservedLoadChange, FadesOverTheFramesThatFollowAndEndsWithTheContact) {
  UnobservedLoadChange unseen;
  unseen.update(patch(2, 0), kMovedFriction);
  unseen.update(patch(1, 0), kMovedFriction);
  const double at_first = unseen.sigma();
  for (int i = 0; i < static_cast<int>(UnobservedLoadChange::kFadeFrames); ++i)
    unseen.update(patch(1, 0), kMovedFriction);
  EXPECT_NEAR(unseen.sigma(), at_first / std::exp(1), 1e-9);
  unseen.reset();
  EXPECT_EQ(unseen.sigma(), 0);
}

}  // namespace
}  // namespace slipd
