// Pillars that slip one after another show their margin before the pad slides.
#include "core/friction/pad_load_sharing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "tests/support/heap_count.hpp"

namespace slipd {
namespace {

constexpr double kPadPitch_m = 0.007, kNoise_n = 1e-4, kPadFriction = 0.6;
using Shares = std::array<double, 9>;
constexpr Shares kUneven{0.4, 0.6, 0.7, 0.9, 1.0, 1.1, 1.3, 1.4, 1.6}, kEven{1, 1, 1, 1, 1, 1, 1, 1, 1},
    kRough{0.2, 0.3, 0.5, 0.8, 1.0, 1.2, 1.5, 1.7, 1.8};

// Nine pillars whose pressures and shears are set.
class Pad {
 public:
  explicit Pad(const Shares& pressed) : pressed_(pressed) {
    for (double& share : pressed_) share /= 9;
  }
  // Pillars that stick are sheared alike, by the shift that makes their sum the pull: found by bisection.
  Shares pull_n(double normal_n, double pull_n) const {
    double low = 0, high = kPadFriction * normal_n;
    Shares carried{};
    for (int step = 0; step < 100; ++step) {
      const double shift = (low + high) / 2;
      for (std::size_t i = 0; i < carried.size(); ++i)
        carried[i] = std::min(shift, kPadFriction * pressed_[i] * normal_n);
      (std::accumulate(carried.begin(), carried.end(), 0.0) < pull_n ? low : high) = shift;
    }
    return carried;
  }
  // Shear at an angle to x.
  const MarginProfile& sense(double normal_n, const Shares& shear_n, double angle_rad = 0) {
    for (std::size_t i = 0; i < pressed_.size(); ++i) {
      normal_pa_[i] = static_cast<float>(pressed_[i] * normal_n / layout_.area_m2());
      shear_x_pa_[i] = static_cast<float>(std::cos(angle_rad) * shear_n[i] / layout_.area_m2());
      shear_y_pa_[i] = static_cast<float>(std::sin(angle_rad) * shear_n[i] / layout_.area_m2());
    }
    ContactPatch patch;
    patch.in_contact = true;
    patch.normal_n = normal_n;
    patch.shear_n = std::accumulate(shear_n.begin(), shear_n.end(), 0.0);
    patch.noise_shear_pa = kNoise_n / layout_.area_m2();
    const Frame frame{.sequence = 1,
                      .time_ns = 0,
                      .normal_pa = normal_pa_,
                      .shear_x_pa = shear_x_pa_,
                      .shear_y_pa = shear_y_pa_,
                      .zeroed = true};
    return shared_.update(frame, patch);
  }
  const MarginProfile& feel_pull(double normal_n, double share) {
    return sense(normal_n, pull_n(normal_n, share * normal_n));
  }
  // Closed, held, and pulled up to this share of P.
  const MarginProfile& pull_up_to(double normal_n, double share) {
    for (int i = 0; i < 20; ++i) sense(normal_n, {});
    for (double now = 0.01; now < share; now += 0.01) feel_pull(normal_n, now);
    return feel_pull(normal_n, share);
  }

 private:
  Shares pressed_;
  TaxelLayout layout_ = TaxelLayout::grid(3, 3, kPadPitch_m);
  std::vector<float> normal_pa_ = std::vector<float>(9), shear_x_pa_ = normal_pa_, shear_y_pa_ = normal_pa_;
  PadLoadSharing shared_{layout_};
};

double likeliest(const MarginProfile& profile) {
  const auto at = std::min_element(profile.misfit.begin(), profile.misfit.end());
  return MarginProfile::gamma_of(static_cast<std::size_t>(at - profile.misfit.begin()));
}

double most(const MarginProfile& profile) {
  return *std::max_element(profile.misfit.begin(), profile.misfit.end());
}

TEST(PadLoadSharing, OfPillarsThatSlipOneByOneShowsTheMargin) {
  for (const double margin : {0.05, 0.2, 0.4}) {
    Pad pad(kUneven);
    const MarginProfile& profile = pad.pull_up_to(5, kPadFriction * (1 - margin));
    ASSERT_TRUE(profile.known);
    EXPECT_NEAR(likeliest(profile), margin, 0.06);
    EXPECT_LT(profile.at(margin), 0.5);
  }
}

TEST(PadLoadSharing, OfAPadThatIsPressedEvenlyShowsNoSlip) {
  Pad pad(kEven);
  const MarginProfile& profile = pad.pull_up_to(5, 0.95 * kPadFriction);
  EXPECT_LT(profile.at(0.9), 0.5);
}

TEST(PadLoadSharing, OfPressingIsNoPull) {
  Pad pad(kUneven);
  Shares askew = kUneven;  // in proportion to the pressure
  for (double& shear_n : askew) shear_n *= 5.0 / 9 * 0.5 * kPadFriction;
  for (int i = 0; i < 40; ++i) EXPECT_FALSE(pad.sense(5, askew).known) << i;
}

TEST(PadLoadSharing, IsReadAnewWhenTheGripperCloses) {
  Pad pad(kUneven);
  ASSERT_TRUE(pad.pull_up_to(5, 0.9 * kPadFriction).known);
  EXPECT_FALSE(pad.feel_pull(6, 0.7 * kPadFriction).known);
}

TEST(PadLoadSharing, IsNotReadWhileThePullFalls) {
  Pad pad(kUneven);
  ASSERT_TRUE(pad.pull_up_to(5, 0.9 * kPadFriction).known);
  EXPECT_FALSE(pad.feel_pull(5, 0.6 * kPadFriction).known);
}

// What taxels under a layer sense of it: less of the pattern, and less of all at its edges.
Shares under_layer(const Shares& carried) {
  constexpr Shares kSensed{0.7, 1, 0.75, 1, 1.6, 0.95, 0.75, 1, 0.7};
  const double mean = std::accumulate(carried.begin(), carried.end(), 0.0) / 9;
  Shares sensed{};
  for (std::size_t i = 0; i < sensed.size(); ++i) sensed[i] = kSensed[i] * (mean + 0.4 * (carried[i] - mean));
  return sensed;
}

TEST(PadLoadSharing, UnderALayerFallsWithTheMargin) {
  std::vector<double> read;
  for (const double margin : {0.5, 0.25, 0.05}) {
    Pad pad(kRough);
    for (int i = 0; i < 20; ++i) pad.sense(5, {});
    const MarginProfile* profile = nullptr;
    for (double share = 0.01; share < kPadFriction * (1 - margin); share += 0.01)
      profile = &pad.sense(5, under_layer(pad.pull_n(5, share * 5)));
    ASSERT_TRUE(profile->known);
    read.push_back(likeliest(*profile));
  }
  EXPECT_GT(read[0], read[1]);
  EXPECT_GT(read[1], read[2]);
  EXPECT_LT(read[2], 0.35);
}

// Shares of a pull that stay as they are, whatever they are, are those of taxels that stick.
TEST(PadLoadSharing, ThatStaysAsItBeganIsNoSlip) {
  constexpr Shares kMiddle{0.9, 1, 0.9, 1, 1.3, 1, 0.9, 1, 0.9};
  for (const Shares& shares : {under_layer(kEven), kEven, kMiddle}) {
    const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
    Pad pad(kUneven);
    for (int i = 0; i < 20; ++i) pad.sense(5, {});
    const MarginProfile* profile = nullptr;
    for (double pull_n = 0.05; pull_n < 2; pull_n += 0.05) {
      Shares sensed = shares;
      for (double& shear_n : sensed) shear_n *= pull_n / sum;
      profile = &pad.sense(5, sensed);
    }
    ASSERT_TRUE(profile->known);
    EXPECT_GT(likeliest(*profile), 0.4);
    EXPECT_GT(profile->at(0.05), 4);
  }
}

// Edges of a pad under a layer sense less of pressure and pull alike, which is no slip.
TEST(PadLoadSharing, ThatWentWithThePressureFromTheBeginningIsNoSlip) {
  constexpr Shares kMiddle{0.9, 1, 0.9, 1, 1.3, 1, 0.9, 1, 0.9};
  Pad pad(kMiddle);
  for (int i = 0; i < 20; ++i) pad.sense(5, {});
  const MarginProfile* profile = nullptr;
  for (double share = 0.01; share < 0.35; share += 0.01) {
    Shares sensed = kMiddle;
    for (double& shear_n : sensed) shear_n *= share * 5 / 8.9;
    profile = &pad.sense(5, sensed);
  }
  ASSERT_TRUE(profile->known);
  EXPECT_GT(likeliest(*profile), 0.2);
  EXPECT_GT(profile->at(0.05), 1);
}

// A layer passes shear on along the pull and across it in other shares.
TEST(PadLoadSharing, SaysLessWhenThePullHasTurned) {
  std::vector<double> sure;
  for (const double angle_rad : {0.0, 1.0}) {
    Pad pad(kUneven);
    for (int i = 0; i < 20; ++i) pad.sense(5, {});
    for (double share = 0.01; share < 0.2; share += 0.01) pad.sense(5, under_layer(pad.pull_n(5, share * 5)));
    const MarginProfile& profile =
        pad.sense(5, under_layer(pad.pull_n(5, 0.97 * kPadFriction * 5)), angle_rad);
    ASSERT_TRUE(profile.known);
    sure.push_back(most(profile));
  }
  EXPECT_LT(sure[1], 0.6 * sure[0]);
}

// Taxels that carry many times the pull against each other.
TEST(PadLoadSharing, StaysFiniteWhateverTaxelsCarry) {
  Pad pad(kUneven);
  for (int i = 0; i < 20; ++i) pad.sense(5, {});
  for (double share = 0.01; share < 0.2; share += 0.01) pad.feel_pull(5, share);
  Shares wild{300, -300, 200, -200, 100, -100, 50, -50, 2};
  const MarginProfile& profile = pad.sense(5, wild);
  ASSERT_TRUE(profile.known);
  for (const double misfit : profile.misfit) EXPECT_TRUE(std::isfinite(misfit));
}

TEST(PadLoadSharing, NeedsAFewTaxels) {
  EXPECT_THROW(PadLoadSharing(TaxelLayout::grid(2, 2, kPadPitch_m)), std::invalid_argument);
  EXPECT_THROW(PadLoadSharing(TaxelLayout::grid(9, 9, kPadPitch_m)), std::invalid_argument);
}

TEST(PadLoadSharing, AllocatesNothing) {
  Pad pad(kUneven);
  pad.pull_up_to(5, 0.5 * kPadFriction);
  const Shares carried = pad.pull_n(5, 0.9 * kPadFriction * 5);
  const auto before = test::allocations();
  pad.sense(5, carried);
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace slipd
