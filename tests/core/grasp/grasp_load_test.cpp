// Fingers on one rigid body: against closed forms for a pair, against the sum rule, and against plain
// searches.
#include "core/grasp/grasp_load.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/contact/limit_surface.hpp"
#include "core/grasp/grasp.hpp"
#include "tests/support/heap_count.hpp"

namespace slipd {
namespace {

constexpr double kHalf = 0.02, kRadius = 4e-3;  // m: half of what the fingers are apart, contact radius

// Two opposed fingers on the z axis, each with x along the world's.
FingerPose low_finger() {
  FingerPose pose;
  EXPECT_TRUE(make_pose({0, 0, -kHalf}, {0, 0, 1}, {1, 0, 0}, pose));
  return pose;
}
FingerPose high_finger() {
  FingerPose pose;
  EXPECT_TRUE(make_pose({0, 0, kHalf}, {0, 0, -2}, {3, 0, 0.5}, pose));
  return pose;
}
std::vector<FingerLoad> pair(double low_limit_n, double high_limit_n) {
  return {{.pose = low_finger(), .limit_n = low_limit_n, .radius_m = kRadius},
          {.pose = high_finger(), .limit_n = high_limit_n, .radius_m = kRadius}};
}

double hertz_share(double shear_n, double torque_nm, double limit_n) {
  return contact::unit_hertz_surface()
      .least_friction(shear_n / limit_n, 0, torque_nm / (limit_n * kRadius))
      .ratio;
}

TEST(GraspLoad, AxesOfAPoseAreAtRightAngles) {
  const FingerPose pose = high_finger();
  EXPECT_NEAR(pose.x[0], 1, 1e-12);
  EXPECT_NEAR(pose.y[1], -1, 1e-12);
  FingerPose none;
  EXPECT_FALSE(make_pose({}, {0, 0, 1}, {0, 0, 3}, none));
  EXPECT_FALSE(make_pose({}, {0, 0, 0}, {1, 0, 0}, none));
}

TEST(GraspLoad, PullsThatAreSharedAsLimitsAreAddUp) {
  auto fingers = pair(2, 1);
  fingers[0].shear_x_n = 0.8;
  fingers[1].shear_x_n = 0.4;
  EXPECT_NEAR(grasp_load(fingers).used_share, 1.2 / 3, 1e-3);
}

// A pull beside the middle between them is shared by the law of the lever: the more loaded finger slides, and
// the object turns about the other. The sum of forces does not see it.
TEST(GraspLoad, APullNearOneFingerIsThatFingers) {
  auto fingers = pair(2, 1);
  fingers[0].shear_x_n = 0.3;
  fingers[1].shear_x_n = 0.9;
  EXPECT_NEAR(grasp_load(fingers).used_share, 0.9, 5e-3);
}

// Of fingers side by side neither is free to: they share a pull until both slide.
TEST(GraspLoad, FingersInOnePlaceShareAPullHoweverItIsMeasured) {
  auto fingers = pair(2, 1);
  fingers[1].pose = fingers[0].pose;
  fingers[0].shear_x_n = 0.3;
  fingers[1].shear_x_n = 0.9;
  EXPECT_NEAR(grasp_load(fingers).used_share, 1.2 / 3, 1e-3);
}

// A torque about the line between them is carried by both contacts as torques.
TEST(GraspLoad, ATorqueAboutTheLineBetweenThemIsThatOfBothContacts) {
  auto fingers = pair(2, 2);
  fingers[0].torque_nm = 1e-3;
  fingers[1].torque_nm = -1e-3;  // its normal points the other way
  EXPECT_NEAR(grasp_load(fingers).used_share, hertz_share(0, 1e-3, 2), 0.01);
  // One of them alone measures it all: the other takes half of it.
  fingers[0].torque_nm = 2e-3;
  fingers[1].torque_nm = 0;
  EXPECT_NEAR(grasp_load(fingers).used_share, hertz_share(0, 1e-3, 2), 0.01);
}

// A torque across the line pulls at the fingers in opposite directions, with all of their distance as lever:
// the sum of forces is 0 and would see no load.
TEST(GraspLoad, ATorqueAcrossTheLineIsCarriedByOppositePulls) {
  auto fingers = pair(2, 2);
  fingers[0].shear_x_n = 0.8;
  fingers[1].shear_x_n = -0.8;
  const double lever = grasp_load(fingers).used_share;
  EXPECT_NEAR(lever, 0.8 / 2, 0.01);
  // The same torque about the line is far more than the pair carries.
  const double torque_nm = 0.8 * kHalf;
  auto twisted = pair(2, 2);
  twisted[0].torque_nm = torque_nm;
  twisted[1].torque_nm = -torque_nm;
  EXPECT_GT(grasp_load(twisted).used_share, 5 * lever);
}

// The weaker finger slides, and turns about the other.
TEST(GraspLoad, OfUnequalFingersALeverIsLimitedByTheWeakerOne) {
  auto fingers = pair(2, 1);
  fingers[0].shear_x_n = 0.6;
  fingers[1].shear_x_n = -0.6;
  const double share = grasp_load(fingers).used_share;
  EXPECT_NEAR(share, 0.6, 0.02);
  EXPECT_GT(grasp_load(fingers).per_limit_n[0], 0.1 * grasp_load(fingers).per_limit_n[1]);
}

TEST(GraspLoad, OneFingerIsItsOwnLimitSurface) {
  for (const double torque_nm : {0.0, 5e-4, -2e-3}) {
    std::vector<FingerLoad> fingers{{.pose = low_finger(),
                                     .shear_x_n = 0.3,
                                     .shear_y_n = 0.4,
                                     .torque_nm = torque_nm,
                                     .limit_n = 1.5,
                                     .radius_m = kRadius}};
    EXPECT_NEAR(grasp_load(fingers).used_share, hertz_share(0.5, torque_nm, 1.5), 0.012) << torque_nm;
  }
}

// No motion may be cheaper than the one found: a bound that coarse searches cannot go below.
TEST(GraspLoad, NoRigidMotionOfThreeFingersIsCheaper) {
  std::vector<FingerLoad> fingers(3);
  for (std::size_t i = 0; i < 3; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / 3;
    ASSERT_TRUE(make_pose({kHalf * std::cos(angle), kHalf * std::sin(angle), 0},
                          {-std::cos(angle), -std::sin(angle), 0}, {0, 0, 1}, fingers[i].pose));
    fingers[i].shear_x_n = 0.2 + 0.1 * static_cast<double>(i);
    fingers[i].shear_y_n = 0.1;
    fingers[i].torque_nm = 2e-4;
    fingers[i].limit_n = 1 + 0.5 * static_cast<double>(i);
    fingers[i].radius_m = kRadius;
  }
  const GraspLoad load = grasp_load(fingers);
  EXPECT_GT(load.used_share, 0.1);
  // Friction grows everywhere: so does what is carried, in proportion.
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += load.per_limit_n[i] * fingers[i].limit_n;
  EXPECT_NEAR(sum, -load.used_share, 1e-3 * load.used_share);
  // The derivative by a limit is that of a small change: only so at the least power.
  auto more = fingers;
  more[1].limit_n *= 1.05;
  EXPECT_NEAR(grasp_load(more).used_share - load.used_share, load.per_limit_n[1] * 0.05 * fingers[1].limit_n,
              0.01 * load.used_share);
}

TEST(GraspLoad, WithoutLoadOrHoldIsZeroOrEndless) {
  EXPECT_EQ(grasp_load({}).used_share, 0);
  auto fingers = pair(2, 2);
  EXPECT_EQ(grasp_load(fingers).used_share, 0);
  fingers = pair(0, 0);
  fingers[0].shear_x_n = 1;
  EXPECT_TRUE(std::isinf(grasp_load(fingers).used_share));
}

Estimate finger(double normal_n, double shear_n, double friction, double torque_nm) {
  Estimate estimate;
  estimate.state = State::ok;
  estimate.normal_n = normal_n;
  estimate.shear_n = std::fabs(shear_n);
  estimate.shear_x_n = shear_n;
  estimate.shear_y_n = 0;
  estimate.friction = friction;
  estimate.friction_sigma = 0.1 * friction;
  estimate.radius_m = kRadius;
  estimate.torque_nm = torque_nm;
  estimate.pull_n = friction * normal_n * hertz_share(shear_n, torque_nm, friction * normal_n);
  estimate.gamma = 1 - *estimate.pull_n / (friction * normal_n);
  return estimate;
}

TEST(GraspWithPoses, IsTheSumRuleForPullsAlikeAndSeesALeverAndATwistApart) {
  const std::vector<FingerPose> poses{low_finger(), high_finger()};
  const std::vector<Estimate> hanging{finger(4, 0.8, 0.5, 0), finger(4, 0.4, 0.25, 0)};
  const Estimate together = grasp_estimate(hanging, 0.5, poses), sums = grasp_estimate(hanging, 0.5);
  EXPECT_NEAR(*together.gamma, *sums.gamma, 1e-3);
  EXPECT_NEAR(*together.sigma, *sums.sigma, 1e-3);
  EXPECT_NEAR(*together.grip_increase_n, *sums.grip_increase_n, 0.02);
  const std::vector<Estimate> lever{finger(4, 0.4, 0.5, 0), finger(4, -0.4, 0.5, 0)};
  EXPECT_NEAR(*grasp_estimate(lever, 0.5, poses).gamma, 0.8, 0.01);
  const std::vector<Estimate> twist{finger(4, 0, 0.5, 2e-3), finger(4, 0, 0.5, -2e-3)};
  EXPECT_NEAR(*grasp_estimate(twist, 0.5, poses).gamma, 1 - hertz_share(0, 2e-3, 2), 0.01);
}

TEST(GraspWithPoses, AllocatesNothing) {
  const std::vector<FingerPose> poses{low_finger(), high_finger()};
  const std::vector<Estimate> lever{finger(4, 0.4, 0.5, 1e-4), finger(4, -0.4, 0.5, 0)};
  static_cast<void>(grasp_estimate(lever, 0.5, poses));
  const std::uint64_t before = test::allocations();
  static_cast<void>(grasp_estimate(lever, 0.5, poses));
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace slipd
