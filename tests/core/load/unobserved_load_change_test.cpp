// The sigma that is added for forces that moved between two frames.
#include "core/load/unobserved_load_change.hpp"

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

// With the path that its pipeline follows.
class Unobserved {
 public:
  void update(const ContactPatch& patch) {
    change_.update(patch, path_.follow(load_of(0, patch, patch, false)), kMovedFriction);
  }
  void forget() {
    change_.forget();
    path_.forget();
  }
  double sigma() const { return change_.sigma(); }

 private:
  LoadPath path_;
  UnobservedLoadChange change_;
};

TEST(UnobservedLoadChange, OfFramesThatFollowOneAnotherCloselyIsNone) {
  Unobserved unseen;
  unseen.update(patch(0.05, 0));
  for (int i = 1; i <= 200; ++i) {
    unseen.update(patch(2, 0.004 * i));
    if (i == 1) unseen.forget();  // the grip itself is not counted as motion
  }
  EXPECT_EQ(unseen.sigma(), 0);
}

TEST(UnobservedLoadChange, IsNoneInTheFirstFrameWithAnyForces) {
  Unobserved unseen;
  unseen.update(patch(5, 2));
  EXPECT_EQ(unseen.sigma(), 0);
}

TEST(UnobservedLoadChange, GrowsWithTheShareOfTheForceThatMovedAlsoAcross) {
  for (const auto& [next, share] :
       {std::pair(patch(1, 0), 1.0), std::pair(patch(2, 0.4), 0.4), std::pair(patch(2, 0, 0.4), 0.4)}) {
    Unobserved unseen;
    unseen.update(patch(2, 0));
    unseen.update(next);
    EXPECT_NEAR(unseen.sigma(), UnobservedLoadChange::kSigmaOfMotion * share, 0.002);
  }
}

TEST(UnobservedLoadChange, OfNoiseIsNone) {
  ContactPatch first = patch(1, 0), second = patch(1.2, 0.1);
  first.normal_sigma_n = first.shear_sigma_n = second.normal_sigma_n = second.shear_sigma_n = 0.05;
  Unobserved unseen;
  unseen.update(first);
  unseen.update(second);
  EXPECT_EQ(unseen.sigma(), 0);
}

TEST(UnobservedLoadChange, FadesOverTheFramesThatFollowAndEndsWithTheContact) {
  Unobserved unseen;
  unseen.update(patch(2, 0));
  unseen.update(patch(1, 0));
  const double at_first = unseen.sigma();
  for (int i = 0; i < static_cast<int>(UnobservedLoadChange::kFadeFrames); ++i) unseen.update(patch(1, 0));
  EXPECT_NEAR(unseen.sigma(), at_first / std::exp(1), 1e-9);
  unseen.forget();
  EXPECT_EQ(unseen.sigma(), 0);
}

}  // namespace
}  // namespace slipd
