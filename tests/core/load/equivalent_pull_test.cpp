// Force and torque of a frame become the pull that asks for as much of friction.
#include "core/load/equivalent_pull.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/frame/significance.hpp"
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
  PullOfTaxels load(kFine);
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.6, 0.5);
  for (const double noise : {0.0, 0.01, 0.05}) {
    for (int i = 0; i < 50; ++i) {
      const auto& patch =
          finder.find(maker.make(contact, 3e-4, 1e-4, 0.1 * i, noise, synthetic::Noise::sensor));
      const EquivalentPullResult now = load.of(patch, TorqueEffect::none);
      EXPECT_EQ(now.torque_effect, TorqueEffect::none);
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
    PullOfTaxels load(at.layout);
    for (const double shift : {0.0, 10.0, 40.0, 200.0}) {
      const ContactPatch& patch = finder.find(
          frames.make({.center_x_m = 2e-4, .shift_x = 0.6 * shift, .shift_y = -0.8 * shift, .turn = 60}));
      const EquivalentPullResult now = load.of(patch, TorqueEffect::none);
      EXPECT_EQ(now.torque_effect, shift < 100 ? TorqueEffect::changes_shear : now.torque_effect);
      EXPECT_NEAR(now.pull_n / (0.5 * patch.normal_n), 1, at.tolerance) << at.layout.size() << ' ' << shift;
    }
  }
}

TEST(EquivalentPull, ForceVectorsWithATorqueUseTheRadiusThatIsGiven) {
  const TaxelLayout layout = TaxelLayout::wrench(0.02);
  PullOfOneForce load;
  ContactPatch patch;
  patch.in_contact = true;
  patch.normal_n = 10;
  patch.shear_x_n = patch.shear_n = 1.7;
  patch.radius_m = 4e-3;
  patch.torque_nm = 0.236 * 10 * 4e-3 / 2;
  patch.torque_sigma_nm = 1e-5;
  // With mu = 0.5: Q/(mu P) = 0.34 and T/(mu P a) = 0.236, so a little more than by an ellipsoid.
  const double ellipsoid = std::hypot(0.34, 0.236 * 16 / (3 * std::numbers::pi));
  const double share = load.of(patch, TorqueEffect::none).pull_n / (0.5 * patch.normal_n);
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
    const auto load = make_equivalent_pull(layout);
    ContactPatch patch = finder.find(frames.make({.shift_x = 0.1}));
    patch.torque_sigma_nm = 0.05 * patch.normal_n * patch.radius_m;
    const auto with = [&](double sigmas, double pull_share) {
      patch.torque_nm = sigmas * patch.torque_sigma_nm;
      patch.shear_n = patch.shear_x_n = pull_share * patch.normal_n;
      patch.shear_y_n = 0;
      patch.shear_sigma_n = 0.01 * patch.normal_n;
      return load->of(patch, TorqueEffect::none);
    };
    const EquivalentPullResult counted = with(1.1 * kAlikeSigmas, 0.02), covered = with(1, 0.02),
                               pulled = with(1, 0.4);
    EXPECT_EQ(counted.pull_n > 2 * 0.02 * patch.normal_n, coarse);
    EXPECT_EQ(covered.torque_effect, TorqueEffect::none);
    EXPECT_EQ(covered.pull_n, patch.normal_n * 0.02);
    EXPECT_EQ(covered.pull_sigma_n > 0.04 * patch.normal_n, coarse);
    EXPECT_EQ(pulled.pull_n, patch.shear_n);
    EXPECT_EQ(pulled.pull_sigma_n, patch.shear_sigma_n) << "a pull stays as it is";
  }
}

TEST(EquivalentPull, AllocatesNothing) {
  TurningFrames frames(kLarge);
  PatchFinder finder(kLarge);
  PullOfTaxels load(kLarge);
  const ContactPatch& patch = finder.find(frames.make({.shift_x = 0.5, .turn = 0.9}));
  const std::uint64_t before = test::allocations();
  const EquivalentPullResult pull = load.of(patch, TorqueEffect::none);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(pull.torque_effect, TorqueEffect::changes_shear);
}

}  // namespace
}  // namespace slipd
