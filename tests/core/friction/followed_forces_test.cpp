// The forces that the foundations follow: without noise, signed along one axis.
#include "core/friction/followed_forces.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/frame/significance.hpp"
#include "core/health/usual.hpp"

namespace slipd {
namespace {

constexpr double kSigmaN = 0.01;

ContactPatch patch_of(double normal_n, double shear_n, double direction_rad = 0) {
  ContactPatch patch;
  patch.in_contact = true;
  patch.normal_n = normal_n;
  patch.shear_n = std::fabs(shear_n);
  const double sign = shear_n < 0 ? -1 : 1;
  patch.direction_x = sign * std::cos(direction_rad);
  patch.direction_y = sign * std::sin(direction_rad);
  patch.shear_x_n = patch.shear_n * patch.direction_x;
  patch.shear_y_n = patch.shear_n * patch.direction_y;
  patch.normal_sigma_n = patch.shear_sigma_n = kSigmaN;
  return patch;
}

TEST(FollowedForces, ALoadThatIsHeldStandsStillWhateverTheNoise) {
  constexpr int kKnown = 200, kFrames = 20000;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, kSigmaN);
  FollowedForces forces;
  SignedLoad load, least, most;
  for (int i = 0; i < kFrames; ++i) {
    const ContactPatch patch = patch_of(2 + noise(random), 0.5 + noise(random));
    forces.aim(patch);
    load = forces.follow(patch, load);
    if (i == kKnown) least = most = load;
    least = {std::min(least.normal_n, load.normal_n), std::min(least.shear_n, load.shear_n)};
    most = {std::max(most.normal_n, load.normal_n), std::max(most.shear_n, load.shear_n)};
  }
  EXPECT_LT(most.normal_n - least.normal_n, 0.3 * kSigmaN);
  EXPECT_LT(most.shear_n - least.shear_n, 0.3 * kSigmaN);
  EXPECT_NEAR(load.normal_n, 2, 0.5 * kSigmaN);
  EXPECT_NEAR(load.shear_n, 0.5, 0.5 * kSigmaN);
}

TEST(FollowedForces, DifferFromALoadThatTurnsByThreeSigmaAtMost) {
  const FollowedForcesOptions options;
  FollowedForces forces(options);
  SignedLoad load;
  for (int i = 0; i <= 400; ++i) {
    const double normal_n = 2 + std::sin(0.05 * i), shear_n = 0.6 * std::sin(0.03 * i);
    const ContactPatch patch = patch_of(normal_n, shear_n);
    forces.aim(patch);
    load = forces.follow(patch, load);
    EXPECT_LE(std::fabs(load.normal_n - normal_n), kClearSigmas * kSigmaN + options.band_share * normal_n);
    EXPECT_LE(std::fabs(load.shear_n - shear_n), kClearSigmas * kSigmaN + options.band_share * normal_n);
  }
}

TEST(FollowedForces, AReversedShearIsNegativeAlongTheSameAxis) {
  FollowedForces forces;
  SignedLoad load;
  for (double shear_n = 0; shear_n < 0.8; shear_n += 0.02) {
    EXPECT_FALSE(forces.aim(patch_of(2, shear_n, 0.4)));
    load = forces.follow(patch_of(2, shear_n, 0.4), load);
  }
  EXPECT_GT(load.shear_n, 0.7);
  for (double shear_n = 0.8; shear_n > -0.8; shear_n -= 0.02) {
    EXPECT_FALSE(forces.aim(patch_of(2, shear_n, 0.4)));
    load = forces.follow(patch_of(2, shear_n, 0.4), load);
  }
  EXPECT_LT(load.shear_n, -0.7);
  EXPECT_NEAR(forces.axis().cosine(patch_of(2, -0.8, 0.4)), -1, 1e-9);
}

TEST(FollowedForces, ShearThatTurnsFromAKnownAxisIsReportedOnce) {
  FollowedForces forces;
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(forces.aim(patch_of(2, 0.5, 0)));
  const ContactPatch turned = patch_of(2, 0.5, std::numbers::pi / 2);
  EXPECT_TRUE(forces.aim(turned));
  EXPECT_NEAR(forces.axis().cosine(turned), 1, 1e-9);
  EXPECT_DOUBLE_EQ(forces.follow(turned, {2, turned.shear_n}).shear_n, 0.5)
      << "signed anew along the new axis";
  EXPECT_FALSE(forces.aim(turned));
}

TEST(FollowedForces, ShearWithoutAClearDirectionMayTurn) {
  FollowedForces forces;
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(forces.aim(patch_of(2, 5 * kSigmaN, i)));
}

TEST(FollowedForces, AGraspThatGrowsBeganWithItsFirstFrame) {
  FollowedForces forces;
  for (int i = 1; i <= 20; ++i) EXPECT_FALSE(forces.loaded_at_onset(patch_of(0.2 * i, 0.1 * i)));
}

TEST(FollowedForces, AGraspWithoutShearBeganWithItsFirstFrame) {
  FollowedForces forces;
  for (int i = 1; i <= 20; ++i) EXPECT_FALSE(forces.loaded_at_onset(patch_of(2, 0)));
}

TEST(FollowedForces, AGraspThatIsLoadedAndDoesNotGrowWasMetUnderLoad) {
  FollowedForces forces;
  for (std::uint32_t i = 1; i <= 20; ++i)
    EXPECT_EQ(forces.loaded_at_onset(patch_of(2, 0.5)), i == kSureFrames) << "frame " << i;
  forces.reset();
  for (std::uint32_t i = 1; i <= 20; ++i)
    EXPECT_EQ(forces.loaded_at_onset(patch_of(2, 0.5)), i == kSureFrames) << "after a reset";
}

}  // namespace
}  // namespace slipd
