// A taxel that stands alone is left out, a small contact is not.
#include "core/health/spike_finder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

// Of the paper's stiffest objects: 3 R/(4 E*), R = 5 mm, E* = 0.63 MPa; of its softest.
constexpr double kLeast_m3_per_n = 6e-9, kGreatest_m3_per_n = 8e-8;

class Spikes : public ::testing::Test {
 protected:
  std::size_t find(std::size_t taxel, float pressure_pa) {
    contact_.move_to(3, 0.5, 0.5);
    Frame frame = maker_.make(contact_, 0.3e-3, -0.2e-3, 0.3, 0.01);
    std::vector<float> normal(frame.normal_pa.begin(), frame.normal_pa.end());
    normal[taxel] = pressure_pa;
    frame.normal_pa = normal;
    const std::size_t found = spikes_.find(frame, finder_.find(frame));
    const Frame mended = spikes_.mended(frame);
    if (found > 0) mended_pa_ = mended.normal_pa[taxel];
    return found;
  }

  TaxelLayout layout_ = TaxelLayout::grid(16, 16, 0.9e-3);
  PlausibilityLimits limits_{.full_scale = default_full_scale(SensorClass::array3, layout_),
                             .least_m3_per_n = kLeast_m3_per_n,
                             .greatest_m3_per_n = kGreatest_m3_per_n};
  SpikeFinder spikes_{layout_, limits_};
  PatchFinder finder_{layout_};
  synthetic::FrameMaker maker_{layout_};
  contact::LoadHistory contact_{synthetic::paper_pair()};
  float mended_pa_ = 0;
};

TEST_F(Spikes, OfOneTaxelAreLeftOutAndNeighboursStandForIt) {
  constexpr std::size_t kMiddle = 8 * 16 + 8, kCorner = 0;
  const std::size_t places[] = {kMiddle, kCorner};
  const float values[] = {5e6F,
                          1e8F,
                          1e30F,
                          std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()};
  for (const std::size_t place : places) {
    for (const float value : values) {
      EXPECT_EQ(find(place, value), 1U) << value << " at " << place;
      EXPECT_LT(std::fabs(mended_pa_), 2e5F) << value << " at " << place;
    }
  }
}

TEST_F(Spikes, AreNotSeenInContactsOfAnySize) {
  for (int i = 1; i <= 400; ++i) {
    contact_.move_to(0.02 * i, 0.005 * i, 0.5);
    const Frame frame = maker_.make(contact_, 1e-5 * i, -0.7e-5 * i, 0.3, 0.01);
    EXPECT_EQ(spikes_.find(frame, finder_.find(frame)), 0U) << 0.02 * i << " N";
  }
}

}  // namespace
}  // namespace slipd
