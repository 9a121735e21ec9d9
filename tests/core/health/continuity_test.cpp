// Another contact's frames are a jump, and motions of one contact are not.
#include "core/health/continuity.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

constexpr ContinuityOptions kContinuity;
constexpr double kFriction = 0.5, kNoise = 0.01;

class ContactThatGoesOn : public ::testing::TestWithParam<std::size_t> {
 protected:
  // One frame of a contact with these forces at this place.
  Health sense(double normal_n, double shear_n, double x_m, double direction_rad) {
    contact_.move_to(normal_n, shear_n, kFriction);
    Frame frame = maker_.make(contact_, x_m, 0, direction_rad, kNoise, synthetic::Noise::sensor);
    frame.time_ns = time_ns_ += step_ns_;
    return judge(frame);
  }
  Health judge(const Frame& frame) {
    probes_.update(frame);
    const SeenFrame now{frame.time_ns, finder_.find(frame)};
    const Health health = continuity_->update(now, before_, probes_.pattern(), probes_.size());
    before_ = now;
    return health;
  }
  void hold() {
    for (int i = 0; i < 50; ++i) ASSERT_EQ(sense(3, 0.6, 0, 0.3), Health::good) << i;
  }

  std::int64_t time_ns_ = 0, step_ns_ = 1'000'000;
  TaxelLayout layout_ = TaxelLayout::grid(GetParam(), GetParam(),
                                          GetParam() == 4 ? 4.7e-3 : 16e-3 / static_cast<double>(GetParam()));
  Probes probes_{layout_, 192};
  PatchFinder finder_{layout_};
  synthetic::FrameMaker maker_{layout_};
  contact::LoadHistory contact_{synthetic::paper_pair()};
  std::optional<Continuity> continuity_{kContinuity};
  std::optional<SeenFrame> before_;
};

TEST_P(ContactThatGoesOn, MayGrowByATenthOfItsForceEachFrame) {
  hold();
  for (double normal_n = 3; normal_n < 12; normal_n *= 1.1)
    EXPECT_EQ(sense(normal_n, 0.6, 0, 0.3), Health::good) << normal_n << " N";
}

TEST_P(ContactThatGoesOn, OfASlowSensorMayBeGrippedThreeTimesAsHardAtOnce) {
  step_ns_ = 20'000'000;
  for (const double grip_n : {9.0, 3.0, 1.5, 4.5}) {
    hold();
    for (int i = 0; i < 5; ++i) EXPECT_EQ(sense(grip_n, 0.2, 0, 0.3), Health::good) << grip_n << " N, " << i;
  }
}

TEST_P(ContactThatGoesOn, OfASlowSensorIsNotGrippedHarderElsewhere) {
  step_ns_ = 20'000'000;
  hold();
  EXPECT_EQ(sense(9, 0.2, 3e-3, 0.3), Health::jump);
}

TEST_P(ContactThatGoesOn, MayMoveByATenthOfATaxelEachFrame) {
  hold();
  for (int i = 1; i <= 20; ++i) EXPECT_EQ(sense(3, 0.6, 1e-5 * i, 0.3), Health::good) << i;
}

// As an object does that begins to slide. Its last steps change the pressures more than a jump must, and by
// more than the usual factor.
TEST_P(ContactThatGoesOn, MayMoveFasterAndFaster) {
  hold();
  double x_m = -4e-3, most_unlike = 0;
  sense(1e-9, 0, x_m, 0.3);  // put down elsewhere
  for (int i = 0; i < 50; ++i) ASSERT_EQ(sense(3, 0.6, x_m, 0.3), Health::good) << i;
  for (double step_m = 1e-5; step_m < 1.2e-3; step_m *= 1.25) {
    x_m += step_m;
    EXPECT_EQ(sense(3, 0.6, x_m, 0.3), Health::good) << step_m << " m";
    most_unlike = std::max(most_unlike, probes_.pattern().unlikeness());
  }
  EXPECT_GT(most_unlike, 2 * kContinuity.least_unlike_fast);
}

TEST_P(ContactThatGoesOn, MayTurnItsShearSlowly) {
  hold();
  for (int i = 1; i <= 60; ++i) EXPECT_EQ(sense(3, 0.6, 0, 0.3 + 0.05 * i), Health::good) << i;
}

TEST_P(ContactThatGoesOn, IsNotTheSameElsewhereUntilItIsLetGo) {
  hold();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(sense(3, 0.6, 3e-3, 0.3), Health::jump) << i;
  sense(1e-9, 0, 3e-3, 0.3);
  EXPECT_EQ(sense(3, 0.6, 3e-3, 0.3), Health::good);
}

TEST_P(ContactThatGoesOn, DoesNotTurnItsShearAtOnce) {
  hold();
  EXPECT_EQ(sense(3, 0.6, 0, 1.3), Health::jump);
}

TEST_P(ContactThatGoesOn, DoesNotCarryATwentiethOrFiftyTimesAsMuchOnTheSamePatch) {
  for (const float by : {0.02F, 50.0F}) {
    continuity_.emplace(kContinuity);
    before_.reset();
    hold();
    const Frame frame = maker_.make(contact_, 0, 0, 0.3, kNoise, synthetic::Noise::sensor);
    const std::array channels{frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa};
    std::array<std::vector<float>, 3> scaled;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      for (const float value : channels[c]) scaled[c].push_back(by * value);
    }
    const Frame wrong{frame.sequence, time_ns_ += step_ns_, scaled[0], scaled[1], scaled[2]};
    EXPECT_EQ(judge(wrong), Health::wrong_scale) << by;
  }
}

INSTANTIATE_TEST_SUITE_P(Sides, ContactThatGoesOn, ::testing::Values(4, 16, 100));

}  // namespace
}  // namespace slipd
