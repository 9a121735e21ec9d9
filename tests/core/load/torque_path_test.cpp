// What the path of force and torque says of a load: at its maximum, straight, without traces of earlier
// loads.
#include "core/load/torque_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace slipd {
namespace {

constexpr double kPathFriction = 0.5;

// Of a sensor of one force and its torque.
class FollowedLoad {
 public:
  TorquePathState of(const ContactPatch& patch) {
    const EquivalentPullResult pull = pull_.of(patch, previous_);
    previous_ = pull.torque_effect;
    return path_.follow(patch, pull, kPathFriction);
  }
  void forget() {
    previous_ = TorqueEffect::none;
    path_.forget();
  }

 private:
  PullOfOneForce pull_;
  TorqueEffect previous_ = TorqueEffect::none;
  TorquePath path_;
};

// The path of the load: straight, bent, and at a grip that was tightened.
TEST(TorquePath, SaysWhetherTheLoadCameInAStraightLine) {
  ContactPatch patch;
  patch.in_contact = true;
  patch.normal_n = 2;
  patch.radius_m = 3e-3;
  patch.shear_sigma_n = 1e-4;
  patch.torque_sigma_nm = 1e-7;
  FollowedLoad load;
  const auto pull_and_turn = [&](double pull_n, double torque_nm) {
    patch.shear_x_n = patch.shear_n = pull_n;
    patch.torque_nm = torque_nm;
    return load.of(patch).straight;
  };
  for (int i = 0; i <= 100; ++i) EXPECT_TRUE(pull_and_turn(0.004 * i, 1.2e-5 * i)) << i;
  EXPECT_FALSE(pull_and_turn(0.3, 9e-4)) << "fallen";
  EXPECT_TRUE(pull_and_turn(0.4, 1.2e-3)) << "back on the same line";
  patch.normal_n = 2.4;
  EXPECT_FALSE(pull_and_turn(0.4, 1.2e-3)) << "tightened";
  load.forget();
  patch.normal_n = 2;
  for (int i = 0; i <= 100; ++i) EXPECT_TRUE(pull_and_turn(0.004 * i, 0)) << i;
  for (int i = 10; i <= 100; ++i) pull_and_turn(0.4, 1.2e-5 * i);
  EXPECT_FALSE(pull_and_turn(0.4, 1.2e-3)) << "a turn after a pull";
}

// Friction shows at the maximum of the load, also after a gripper has answered: the contact's radius, and so
// the lever of friction's torque, is another one then, the load of the object is not.
TEST(TorquePath, SeesALoadReachItsMaximumAgainAfterTheGripHasChanged) {
  ContactPatch patch;
  patch.in_contact = true;
  patch.shear_sigma_n = 1e-4;
  patch.torque_sigma_nm = 1e-7;
  for (const double grip : {0.7, 0.9, 1.2, 2.0}) {
    FollowedLoad load;
    const auto hold = [&](double by_grip, double share) {
      patch.normal_n = 4 * by_grip;
      patch.radius_m = 3.8e-3 * std::cbrt(by_grip);
      patch.shear_x_n = patch.shear_n = 0.2 * share;
      patch.torque_nm = 4e-3 * share;
      return load.of(patch).risen;
    };
    for (int i = 1; i <= 100; ++i) EXPECT_TRUE(hold(1, 0.01 * i)) << i;
    EXPECT_FALSE(hold(grip, 0.9)) << grip;
    EXPECT_TRUE(hold(grip, 1.02)) << grip;  // a new maximum, by a little
    EXPECT_FALSE(hold(grip, 0.9)) << grip;
    EXPECT_TRUE(hold(grip, 1)) << grip;
    EXPECT_FALSE(hold(1, 0.9)) << grip;
    EXPECT_TRUE(hold(1, 1)) << grip;
  }
}

// Mindlin and Deresiewicz: what sticks bears P - Q/mu, and slip goes over all traces once that is less than
// ever before.
TEST(TorquePath, SaysWhenWhatSticksBearsItsLeastLoad) {
  ContactPatch patch;
  patch.in_contact = true;
  patch.radius_m = 3e-3;
  patch.shear_sigma_n = 1e-4;
  FollowedLoad load;
  const auto sticks_least = [&](double normal_n, double pull_n) {
    patch.normal_n = normal_n;
    patch.shear_x_n = patch.shear_n = pull_n;
    return load.of(patch).least_stuck;
  };
  for (int i = 1; i <= 100; ++i) sticks_least(0.02 * i, 0);
  for (int i = 1; i <= 60; ++i) EXPECT_TRUE(sticks_least(2, 0.01 * i)) << i;  // what sticks bears 0.8 N
  EXPECT_FALSE(sticks_least(2, 0.5)) << "fallen";
  EXPECT_TRUE(sticks_least(2, 0.6));
  EXPECT_FALSE(sticks_least(3, 0.6)) << "tightened";
  EXPECT_FALSE(sticks_least(3, 0.95)) << "risen, but 1.1 N stick";
  EXPECT_TRUE(sticks_least(3, 1.1));
  EXPECT_TRUE(sticks_least(2.5, 1.0)) << "eased: 0.5 N stick";
  load.forget();
  EXPECT_TRUE(sticks_least(3, 0.6)) << "a new grasp";
}

}  // namespace
}  // namespace slipd
