// Moments of the shear under force and torque, far from slip: no taxel slips there, and how far out the shear
// lies is all that shows it.
#include "core/reading/torque/torque_moment_ratio.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/contact/averages.hpp"
#include "core/load/equivalent_pull.hpp"
#include "core/patch/patch.hpp"

namespace slipd {
namespace {

constexpr double kContactRadius = 4e-3, kPeak = 60e3;  // m, Pa

// Contacts that stick all over: a Hertz pressure, and the shear (c + d x r)/sqrt(1 - r^2) of a half space
// that is shifted and turned.
class StickingContact {
 public:
  explicit StickingContact(const TaxelLayout& layout) : layout_(layout) {
    for (auto& channel : channels_) channel.resize(layout.size());
  }

  // shift, turn: shear in the middle, and what the turn adds at half the radius, of the peak.
  Frame make(double shift, double turn, double noise) {
    constexpr int kParts = 8;
    const double side = layout_.side_m();
    std::uniform_real_distribution<double> unit(-noise, noise);
    for (std::size_t i = 0; i < layout_.size(); ++i) {
      double x_pa = 0, y_pa = 0;
      for (int part = 0; part < kParts * kParts; ++part) {
        const int row = part / kParts, column = part % kParts;
        const double x = (layout_.x_m()[i] + ((column + 0.5) / kParts - 0.5) * side) / kContactRadius;
        const double y = (layout_.y_m()[i] + ((row + 0.5) / kParts - 0.5) * side) / kContactRadius;
        const double rest = 1 - x * x - y * y;
        if (!(rest > 0)) continue;
        const double scale = kPeak / std::sqrt(rest) / (kParts * kParts);
        x_pa += scale * (shift - 2 * turn * y);
        y_pa += scale * 2 * turn * x;
      }
      const double p = kPeak *
                       contact::disc_average_exact(kContactRadius, layout_.x_m()[i], layout_.y_m()[i], side) /
                       kContactRadius;
      channels_[0][i] = static_cast<float>(p + kPeak * unit(random_));
      channels_[1][i] = static_cast<float>(x_pa + kPeak * unit(random_));
      channels_[2][i] = static_cast<float>(y_pa + kPeak * unit(random_));
    }
    return {1, 1'000'000, channels_[0], channels_[1], channels_[2]};
  }

 private:
  TaxelLayout layout_;
  std::mt19937_64 random_{8};
  std::vector<float> channels_[3];
};

class TurningMomentsOn : public ::testing::TestWithParam<std::size_t> {};

TEST_P(TurningMomentsOn, GiveAContactThatSticksAllOverNearlyAllOfItsMarginFromAPullToATorque) {
  const TaxelLayout layout =
      TaxelLayout::grid(GetParam(), GetParam(), 0.0144 / static_cast<double>(GetParam()));
  StickingContact contact(layout);
  PatchFinder finder(layout);
  const TorqueMomentRatio moments(layout);
  for (const double mix : {0.3, 0.8, 1.2, std::numbers::pi / 2}) {
    PullOfTaxels load(layout);
    ContactPatch patch = finder.find(contact.make(0.05 * std::cos(mix), 0.05 * std::sin(mix), 0.002));
    const EquivalentPullResult now = load.of(patch, TorqueEffect::none);
    ASSERT_EQ(now.torque_effect, TorqueEffect::changes_shear) << mix;
    patch.shear_n = now.pull_n;
    const Reading estimate = moments.estimate(patch, now);
    ASSERT_TRUE(estimate.in_model) << mix;
    EXPECT_GT(estimate.gamma, 0.88) << mix;
    EXPECT_LT(1 - estimate.gamma, 3 * estimate.sigma) << mix;
    EXPECT_GT(1 - estimate.gamma, 0.99 * estimate.sigma) << "as good as no load, " << mix;
  }
}

INSTANTIATE_TEST_SUITE_P(Sides, TurningMomentsOn, ::testing::Values(24, 32, 64));

}  // namespace
}  // namespace slipd
