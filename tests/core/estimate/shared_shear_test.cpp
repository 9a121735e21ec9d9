// Pillars that slip one after another show their margin before the pad slides.
#include "core/estimate/shared_shear.hpp"

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

constexpr double kPitch_m = 0.007, kNoise_n = 1e-4, kFriction = 0.6;
using Shares = std::array<double, 9>;
constexpr Shares kUneven{0.4, 0.6, 0.7, 0.9, 1.0, 1.1, 1.3, 1.4, 1.6}, kEven{1, 1, 1, 1, 1, 1, 1, 1, 1};

// Nine pillars whose pressures and shears are set.
class Pad {
 public:
  explicit Pad(const Shares& pressed) : pressed_(pressed) {
    for (double& share : pressed_) share /= 9;
  }
  // Pillars that stick are sheared alike, by the shift that makes their sum the pull: found by bisection.
  Shares pull_n(double normal_n, double pull_n) const {
    double low = 0, high = kFriction * normal_n;
    Shares carried{};
    for (int step = 0; step < 100; ++step) {
      const double shift = (low + high) / 2;
      for (std::size_t i = 0; i < carried.size(); ++i)
        carried[i] = std::min(shift, kFriction * pressed_[i] * normal_n);
      (std::accumulate(carried.begin(), carried.end(), 0.0) < pull_n ? low : high) = shift;
    }
    return carried;
  }
  // Shear along x.
  const MarginProfile& feel(double normal_n, const Shares& shear_n) {
    for (std::size_t i = 0; i < pressed_.size(); ++i) {
      normal_pa_[i] = static_cast<float>(pressed_[i] * normal_n / layout_.area_m2());
      shear_x_pa_[i] = static_cast<float>(shear_n[i] / layout_.area_m2());
    }
    ContactPatch patch;
    patch.in_contact = true;
    patch.normal_n = normal_n;
    patch.shear_x_n = patch.shear_n = std::accumulate(shear_n.begin(), shear_n.end(), 0.0);
    patch.noise_shear_pa = kNoise_n / layout_.area_m2();
    patch.taxels = TaxelView{normal_pa_.data(), shear_x_pa_.data(), shear_y_pa_.data(), nullptr, nullptr, 9};
    return shared_.update(patch);
  }
  const MarginProfile& feel_pull(double normal_n, double share) {
    return feel(normal_n, pull_n(normal_n, share * normal_n));
  }
  // Closed, held, and pulled up to this share of P.
  const MarginProfile& pull_up_to(double normal_n, double share) {
    for (int i = 0; i < 20; ++i) feel(normal_n, {});
    for (double now = 0.01; now < share; now += 0.01) feel_pull(normal_n, now);
    return feel_pull(normal_n, share);
  }

 private:
  Shares pressed_;
  TaxelLayout layout_ = TaxelLayout::grid(3, 3, kPitch_m);
  std::vector<float> normal_pa_ = std::vector<float>(9), shear_x_pa_ = normal_pa_, shear_y_pa_ = normal_pa_;
  SharedShear shared_{layout_};
};

double likeliest(const MarginProfile& profile) {
  const auto at = std::min_element(profile.misfit.begin(), profile.misfit.end());
  return MarginProfile::gamma_of(static_cast<std::size_t>(at - profile.misfit.begin()));
}

double most(const MarginProfile& profile) {
  return *std::max_element(profile.misfit.begin(), profile.misfit.end());
}

TEST(SharedShear, OfPillarsThatSlipOneByOneShowsTheMargin) {
  for (const double margin : {0.05, 0.2, 0.4}) {
    Pad pad(kUneven);
    const MarginProfile& profile = pad.pull_up_to(5, kFriction * (1 - margin));
    ASSERT_TRUE(profile.known);
    EXPECT_NEAR(likeliest(profile), margin, 0.06);
    EXPECT_LT(profile.at(margin), 0.5);
  }
}

TEST(SharedShear, OfAPadThatIsPressedEvenlyShowsNothing) {
  Pad pad(kEven);
  const MarginProfile& profile = pad.pull_up_to(5, 0.95 * kFriction);
  EXPECT_LT(most(profile), 0.5);
}

TEST(SharedShear, OfPressingIsNoPull) {
  Pad pad(kUneven);
  Shares askew = kUneven;  // in proportion to the pressure
  for (double& shear_n : askew) shear_n *= 5.0 / 9 * 0.5 * kFriction;
  for (int i = 0; i < 40; ++i) EXPECT_FALSE(pad.feel(5, askew).known) << i;
}

TEST(SharedShear, IsReadAnewWhenTheGripperCloses) {
  Pad pad(kUneven);
  ASSERT_TRUE(pad.pull_up_to(5, 0.9 * kFriction).known);
  EXPECT_FALSE(pad.feel_pull(6, 0.7 * kFriction).known);
}

TEST(SharedShear, IsNotReadWhileThePullFalls) {
  Pad pad(kUneven);
  ASSERT_TRUE(pad.pull_up_to(5, 0.9 * kFriction).known);
  EXPECT_FALSE(pad.feel_pull(5, 0.6 * kFriction).known);
}

// A layer evens out half of the pattern. It is then read by how far it has gone.
TEST(SharedShear, UnderALayerFallsWithTheMargin) {
  const auto spread = [](Shares carried) {
    const double mean = std::accumulate(carried.begin(), carried.end(), 0.0) / 9;
    for (double& of : carried) of = mean + 0.5 * (of - mean) + 0.03 * mean;
    return carried;
  };
  std::vector<double> read;
  for (const double margin : {0.5, 0.25, 0.05}) {
    Pad pad(kUneven);
    for (int i = 0; i < 20; ++i) pad.feel(5, {});
    const MarginProfile* profile = nullptr;
    for (double share = 0.01; share < kFriction * (1 - margin); share += 0.01)
      profile = &pad.feel(5, spread(pad.pull_n(5, share * 5)));
    ASSERT_TRUE(profile->known);
    read.push_back(likeliest(*profile));
  }
  EXPECT_GT(read[0], read[1]);
  EXPECT_GT(read[1], read[2]);
  EXPECT_LT(read[2], 0.35);
}

TEST(SharedShear, NeedsAFewTaxels) {
  EXPECT_THROW(SharedShear(TaxelLayout::grid(2, 2, kPitch_m)), std::invalid_argument);
  EXPECT_THROW(SharedShear(TaxelLayout::grid(9, 9, kPitch_m)), std::invalid_argument);
}

TEST(SharedShear, AllocatesNothing) {
  Pad pad(kUneven);
  pad.pull_up_to(5, 0.5 * kFriction);
  const Shares carried = pad.pull_n(5, 0.9 * kFriction * 5);
  const auto before = test::allocations();
  pad.feel(5, carried);
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace slipd
