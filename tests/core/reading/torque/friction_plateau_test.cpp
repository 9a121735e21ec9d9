// Friction is read where taxels slip under force and torque.
#include "core/reading/torque/friction_plateau.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/load/equivalent_pull.hpp"
#include "tests/support/heap_count.hpp"
#include "tests/support/synthetic.hpp"
#include "tests/support/turning_frames.hpp"

namespace slipd {
namespace {

using synthetic::Turned;
using synthetic::TurningFrames;

const TaxelLayout kPlateauTaxels = TaxelLayout::grid(32, 32, 0.00045);

TEST(FrictionPlateau, AllocatesNothing) {
  TurningFrames frames(kPlateauTaxels);
  PatchFinder finder(kPlateauTaxels);
  PullOfTaxels load(kPlateauTaxels);
  FrictionPlateau slipping(kPlateauTaxels);
  ContactPatch loaded = finder.find(frames.make({.shift_x = 0.5, .turn = 0.9}));
  loaded.shear_n = load.of(loaded, TorqueEffect::none).pull_n;
  const std::uint64_t before = test::allocations();
  const Reading estimate = slipping.estimate(loaded);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_TRUE(estimate.in_model);
}

class SlippingTaxelsUnderNoise : public ::testing::TestWithParam<double> {};

TEST_P(SlippingTaxelsUnderNoise, TellFrictionFromForceAndTorqueOrNothing) {
  const double noise = GetParam();
  TurningFrames frames(kPlateauTaxels);
  PatchFinder finder(kPlateauTaxels);
  PullOfTaxels load(kPlateauTaxels);
  FrictionPlateau slipping(kPlateauTaxels);
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
    const EquivalentPullResult now = load.of(patch, TorqueEffect::none);
    loaded.shear_n = now.pull_n;
    loaded.shear_sigma_n = now.pull_sigma_n;
    const Reading out = slipping.estimate(loaded);
    const double gamma = 1 - now.pull_n / (friction * patch.normal_n);
    EXPECT_TRUE(out.under_torque);
    heavy += gamma < 0.6 ? 1 : 0;
    answered += out.in_model && gamma < 0.6 ? 1 : 0;
    if (!out.in_model) continue;
    EXPECT_NEAR(out.friction / friction, 1, std::max(0.02, 4 * out.friction_sigma / friction)) << i;
    EXPECT_LT(out.gamma - gamma, 0.05) << "too safe, " << i;
  }
  EXPECT_GT(answered, (noise > 0.02 ? 0.5 : 0.85) * heavy);
}

INSTANTIATE_TEST_SUITE_P(Sensors, SlippingTaxelsUnderNoise, ::testing::Values(0.0, 0.01, 0.03));

}  // namespace
}  // namespace slipd
