// Force and torque of a frame become the pull that asks for as much of friction; friction is read where
// taxels slip.
#include "core/reading/torque/equivalent_pull.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/reading/torque/friction_plateau.hpp"
#include "tests/support/heap_count.hpp"
#include "tests/support/synthetic.hpp"
#include "tests/support/turning_frames.hpp"

namespace slipd {
namespace {

using synthetic::Turned;
using synthetic::TurningFrames;

const TaxelLayout kFine = TaxelLayout::grid(32, 32, 0.00045);
const TaxelLayout kLarge = TaxelLayout::grid(100, 100, 0.000144);

TaxelLayout scattered(std::size_t across, double pitch_m) {
  std::vector<double> x, y;
  for (std::size_t i = 0; i < across * across; ++i) {
    const double shift = 0.25 * static_cast<double>(i / across % 2);
    x.push_back(pitch_m * (static_cast<double>(i % across) + shift - static_cast<double>(across) / 2));
    y.push_back(pitch_m * (static_cast<double>(i / across) - static_cast<double>(across) / 2));
  }
  return TaxelLayout::scattered(x, y);
}

TEST(EquivalentPull, ItsTorqueIsThatOfTheShearAboutTheCentreWithAnHonestSigma) {
  for (const TaxelLayout& layout : {kFine, scattered(32, 0.00045)}) {
    TurningFrames frames(layout);
    PatchFinder finder(layout);
    double squares = 0;
    constexpr int kFrames = 60;
    for (int i = 0; i < kFrames; ++i) {
      const Turned contact{
          .center_x_m = 3e-4, .center_y_m = -2e-4, .shift_x = 0.5, .turn = -0.8, .noise = 0.01};
      const ContactPatch& patch = finder.find(frames.make(contact));
      const double off = (patch.torque_nm - frames.torque_nm()) / patch.torque_sigma_nm;
      EXPECT_LT(std::fabs(off), 6);
      squares += off * off;
    }
    EXPECT_GT(std::sqrt(squares / kFrames), 0.7) << layout.size();
    EXPECT_LT(std::sqrt(squares / kFrames), 1.4) << layout.size();
  }
}

// Pressing alone makes shear that points outwards.
TEST(EquivalentPull, ShearByPressingHasNoTorque) {
  TurningFrames frames(kFine);
  PatchFinder finder(kFine);
  const Frame pressed = frames.make({.center_x_m = 1e-4});
  std::vector<float> x(kFine.size()), y(kFine.size());
  for (std::size_t i = 0; i < kFine.size(); ++i) {
    x[i] = 0.2F * pressed.normal_pa[i] * static_cast<float>((kFine.x_m()[i] - 1e-4) / 4e-3);
    y[i] = 0.2F * pressed.normal_pa[i] * static_cast<float>(kFine.y_m()[i] / 4e-3);
  }
  const ContactPatch& patch = finder.find({1, 1, pressed.normal_pa, x, y});
  EXPECT_LT(std::fabs(patch.torque_nm), 1e-4 * patch.normal_n * patch.radius_m);
}

TEST(EquivalentPull, IsThePullItselfWhereNoiseMayBeAllOfTheTorque) {
  synthetic::FrameMaker maker(kFine);
  PatchFinder finder(kFine);
  EquivalentPull load(kFine);
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.6, 0.5);
  for (const double noise : {0.0, 0.01, 0.05}) {
    for (int i = 0; i < 50; ++i) {
      const auto& patch =
          finder.find(maker.make(contact, 3e-4, 1e-4, 0.1 * i, noise, synthetic::Noise::sensor));
      const EquivalentPullResult now = load.of(patch, 0.5);
      EXPECT_EQ(now.turning, Turning::none);
      EXPECT_EQ(now.pull_n, patch.shear_n);
      EXPECT_EQ(now.pull_sigma_n, patch.shear_sigma_n);
    }
  }
}

// An object that slides about any centre carries all that friction holds: mu P. On any layout, 4 x 4
// included.
TEST(EquivalentPull, AnObjectThatSlidesAboutAnyCentreAsksForAllOfFriction) {
  struct Case {
    TaxelLayout layout;
    double tolerance;
  };
  for (const Case& at :
       {Case{kLarge, 3e-3}, Case{kFine, 3e-3}, Case{scattered(32, 0.00045), 4e-3},
        Case{TaxelLayout::grid(16, 16, 0.0009), 8e-3}, Case{TaxelLayout::grid(6, 6, 0.0024), 3e-2}}) {
    TurningFrames frames(at.layout);
    PatchFinder finder(at.layout);
    EquivalentPull load(at.layout);
    for (const double shift : {0.0, 10.0, 40.0, 200.0}) {
      const ContactPatch& patch = finder.find(
          frames.make({.center_x_m = 2e-4, .shift_x = 0.6 * shift, .shift_y = -0.8 * shift, .turn = 60}));
      const EquivalentPullResult now = load.of(patch, 0.5);
      EXPECT_EQ(now.turning, shift < 100 ? Turning::bending : now.turning);
      EXPECT_NEAR(now.pull_n / (0.5 * patch.normal_n), 1, at.tolerance) << at.layout.size() << ' ' << shift;
    }
  }
}

TEST(EquivalentPull, ForceVectorsWithATorqueUseTheRadiusThatIsGiven) {
  const TaxelLayout layout = TaxelLayout::wrench(0.02);
  EquivalentPull load(layout);
  ContactPatch patch;
  patch.in_contact = true;
  patch.normal_n = 10;
  patch.shear_x_n = patch.shear_n = 1.7;
  patch.radius_m = 4e-3;
  patch.torque_nm = 0.236 * 10 * 4e-3 / 2;
  patch.torque_sigma_nm = 1e-5;
  // With mu = 0.5: Q/(mu P) = 0.34 and T/(mu P a) = 0.236, so a little more than by an ellipsoid.
  const double ellipsoid = std::hypot(0.34, 0.236 * 16 / (3 * std::numbers::pi));
  const double share = load.of(patch, 0.5).pull_n / (0.5 * patch.normal_n);
  EXPECT_GT(share, ellipsoid);
  EXPECT_LT(share, 1.06 * ellipsoid);
}

// On few taxels noise is a large part of a torque, and a torque that noise may be would be all of a light
// load.
TEST(EquivalentPull, OnFewTaxelsATorqueThatOutweighsThePullIsCountedOrCoveredBySigma) {
  const TaxelLayout few = TaxelLayout::grid(4, 4, 0.0036), many = TaxelLayout::grid(8, 8, 0.0018);
  for (const bool coarse : {true, false}) {
    const TaxelLayout& layout = coarse ? few : many;
    TurningFrames frames(layout);
    PatchFinder finder(layout);
    EquivalentPull load(layout);
    ContactPatch patch = finder.find(frames.make({.shift_x = 0.1}));
    patch.torque_sigma_nm = 0.05 * patch.normal_n * patch.radius_m;
    const auto with = [&](double sigmas, double pull_share) {
      patch.torque_nm = sigmas * patch.torque_sigma_nm;
      patch.shear_n = patch.shear_x_n = pull_share * patch.normal_n;
      patch.shear_y_n = 0;
      patch.shear_sigma_n = 0.01 * patch.normal_n;
      return load.of(patch, 0.5);
    };
    const EquivalentPullResult counted = with(2, 0.02), covered = with(1, 0.02), pulled = with(1, 0.4);
    EXPECT_EQ(counted.pull_n > 2 * 0.02 * patch.normal_n, coarse);
    EXPECT_EQ(covered.turning, Turning::none);
    EXPECT_EQ(covered.pull_n, patch.normal_n * 0.02);
    EXPECT_EQ(covered.pull_sigma_n > 0.04 * patch.normal_n, coarse);
    EXPECT_EQ(pulled.pull_n, patch.shear_n);
    EXPECT_EQ(pulled.pull_sigma_n, patch.shear_sigma_n) << "a pull stays as it is";
  }
}

TEST(EquivalentPull, AllocatesNothing) {
  TurningFrames frames(kLarge);
  PatchFinder finder(kLarge);
  EquivalentPull load(kLarge);
  FrictionPlateau slipping(kLarge);
  const ContactPatch& patch = finder.find(frames.make({.shift_x = 0.5, .turn = 0.9}));
  const std::uint64_t before = test::allocations();
  ContactPatch loaded = patch;
  loaded.shear_n = load.of(patch, 0.5).pull_n;
  const Reading estimate = slipping.estimate(loaded);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_TRUE(estimate.in_model);
}

class SlippingTaxelsUnderNoise : public ::testing::TestWithParam<double> {};

TEST_P(SlippingTaxelsUnderNoise, TellFrictionFromForceAndTorqueOrNothing) {
  const double noise = GetParam();
  TurningFrames frames(kFine);
  PatchFinder finder(kFine);
  EquivalentPull load(kFine);
  FrictionPlateau slipping(kFine);
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  int answered = 0, heavy = 0;
  for (int i = 0; i < 150; ++i) {
    const double toward = 2 * std::numbers::pi * unit(random), mix = std::numbers::pi / 2 * unit(random);
    const double size = 0.2 + 2.5 * unit(random), friction = 0.2 + 0.7 * unit(random);
    const Turned contact{.center_x_m = 4e-4 * unit(random),
                         .center_y_m = -4e-4 * unit(random),
                         .radius_m = 3e-3 + 2e-3 * unit(random),
                         .friction = friction,
                         .shift_x = size * std::cos(mix) * std::cos(toward),
                         .shift_y = size * std::cos(mix) * std::sin(toward),
                         .turn = (i % 2 == 0 ? 1.5 : -1.5) * size * std::sin(mix),
                         .noise = noise};
    const ContactPatch& patch = finder.find(frames.make(contact));
    ContactPatch loaded = patch;
    const EquivalentPullResult now = load.of(patch, 0.5);
    loaded.shear_n = now.pull_n;
    loaded.shear_sigma_n = now.pull_sigma_n;
    const Reading out = slipping.estimate(loaded);
    const double gamma = 1 - now.pull_n / (friction * patch.normal_n);
    EXPECT_TRUE(out.turning);
    heavy += gamma < 0.6 ? 1 : 0;
    answered += out.in_model && gamma < 0.6 ? 1 : 0;
    if (!out.in_model) continue;
    EXPECT_NEAR(out.friction / friction, 1, std::max(0.02, 4 * out.friction_sigma / friction)) << i;
    EXPECT_LT(out.gamma - gamma, 0.05) << "too safe, " << i;
  }
  EXPECT_GT(answered, (noise > 0.02 ? 0.5 : 0.85) * heavy);
}

INSTANTIATE_TEST_SUITE_P(Sensors, SlippingTaxelsUnderNoise, ::testing::Values(0.0, 0.01, 0.03));

// The way of the load: straight, bent, and at a grip that was tightened.
TEST(EquivalentPull, SaysWhetherTheLoadCameInAStraightLine) {
  ContactPatch patch;
  patch.in_contact = true;
  patch.normal_n = 2;
  patch.radius_m = 3e-3;
  patch.shear_sigma_n = 1e-4;
  patch.torque_sigma_nm = 1e-7;
  EquivalentPull load(TaxelLayout::wrench(0.01));
  const auto pull_and_turn = [&](double pull_n, double torque_nm) {
    patch.shear_x_n = patch.shear_n = pull_n;
    patch.torque_nm = torque_nm;
    return load.of(patch, 0.5).straight;
  };
  for (int i = 0; i <= 100; ++i) EXPECT_TRUE(pull_and_turn(0.004 * i, 1.2e-5 * i)) << i;
  EXPECT_FALSE(pull_and_turn(0.3, 9e-4)) << "fallen";
  EXPECT_TRUE(pull_and_turn(0.4, 1.2e-3)) << "back on the same line";
  patch.normal_n = 2.4;
  EXPECT_FALSE(pull_and_turn(0.4, 1.2e-3)) << "tightened";
  load.reset();
  patch.normal_n = 2;
  for (int i = 0; i <= 100; ++i) EXPECT_TRUE(pull_and_turn(0.004 * i, 0)) << i;
  for (int i = 10; i <= 100; ++i) pull_and_turn(0.4, 1.2e-5 * i);
  EXPECT_FALSE(pull_and_turn(0.4, 1.2e-3)) << "a turn after a pull";
}

// Friction shows at the maximum of the load, also after a gripper has answered: the contact's radius, and so
// the lever of friction's torque, is another one then, the load of the object is not.
TEST(EquivalentPull, SeesALoadReachItsMaximumAgainAfterTheGripHasChanged) {
  ContactPatch patch;
  patch.in_contact = true;
  patch.shear_sigma_n = 1e-4;
  patch.torque_sigma_nm = 1e-7;
  for (const double grip : {0.7, 0.9, 1.2, 2.0}) {
    EquivalentPull load(TaxelLayout::wrench(0.01));
    const auto hold = [&](double by_grip, double share) {
      patch.normal_n = 4 * by_grip;
      patch.radius_m = 3.8e-3 * std::cbrt(by_grip);
      patch.shear_x_n = patch.shear_n = 0.2 * share;
      patch.torque_nm = 4e-3 * share;
      return load.of(patch, 0.5).risen;
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
TEST(EquivalentPull, SaysWhenWhatSticksBearsItsLeastLoad) {
  constexpr double kFriction = 0.5;
  ContactPatch patch;
  patch.in_contact = true;
  patch.radius_m = 3e-3;
  patch.shear_sigma_n = 1e-4;
  EquivalentPull load(TaxelLayout::wrench(0.01));
  const auto sticks_least = [&](double normal_n, double pull_n) {
    patch.normal_n = normal_n;
    patch.shear_x_n = patch.shear_n = pull_n;
    return load.of(patch, kFriction).least_stuck;
  };
  for (int i = 1; i <= 100; ++i) sticks_least(0.02 * i, 0);
  for (int i = 1; i <= 60; ++i) EXPECT_TRUE(sticks_least(2, 0.01 * i)) << i;  // what sticks bears 0.8 N
  EXPECT_FALSE(sticks_least(2, 0.5)) << "fallen";
  EXPECT_TRUE(sticks_least(2, 0.6));
  EXPECT_FALSE(sticks_least(3, 0.6)) << "tightened";
  EXPECT_FALSE(sticks_least(3, 0.95)) << "risen, but 1.1 N stick";
  EXPECT_TRUE(sticks_least(3, 1.1));
  EXPECT_TRUE(sticks_least(2.5, 1.0)) << "eased: 0.5 N stick";
  load.reset();
  EXPECT_TRUE(sticks_least(3, 0.6)) << "a new grasp";
}

}  // namespace
}  // namespace slipd
