// A pad of pillars on springs, moved by its object, against the beds that follow what it senses. The pad here
// is driven by the object's way, each pillar for itself; the beds know its forces only.
#include "core/friction/pillar_beds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/numeric/random.hpp"
#include "tests/support/heap_count.hpp"

namespace slipd {
namespace {

constexpr std::size_t kSide = 5, kPillars = kSide * kSide;
constexpr double kPillarPitch_m = 0.002, kBetween_s = 0.01;
constexpr std::array<double, 7> kFrictions{0.2, 0.3, 0.4, 0.5, 0.7, 0.9, 1.2};

struct Way {
  double x = 0, y = 0, turn = 0;  // of a pillar at the origin, N of a pillar that sticks; N per pitch
};

class MovedPad {
 public:
  explicit MovedPad(double friction, double noise_n = 0) : friction_(friction), noise_n_(noise_n) {
    patch_.noise_normal_pa = patch_.noise_shear_pa = std::max(noise_n, 1e-5) / layout_.area_m2();
  }

  // A dome: the middle is pressed most, the corners when it is pressed hard.
  void press(double middle_n) {
    for (std::size_t i = 0; i < kPillars; ++i) {
      const double squared = place(i).x * place(i).x + place(i).y * place(i).y;
      pressed_[i] = std::max(0.0, middle_n - 0.1 * squared);
    }
    hold();
  }
  void move(const Way& way) {
    for (std::size_t i = 0; i < kPillars; ++i) {
      load_[i].x += way.x - way.turn * place(i).y;
      load_[i].y += way.y + way.turn * place(i).x;
    }
    hold();
  }
  void set_friction(double friction) {
    friction_ = friction;
    hold();
  }

  // The frame that the pad senses; its patch has the taxels and their noise.
  const ContactPatch& sense() {
    for (std::size_t i = 0; i < kPillars; ++i) {
      const double at = layout_.area_m2();
      channels_[0][i] = static_cast<float>((pressed_[i] + noise()) / at);
      channels_[1][i] = static_cast<float>((load_[i].x + noise()) / at);
      channels_[2][i] = static_cast<float>((load_[i].y + noise()) / at);
    }
    patch_.taxels = {.normal_pa = channels_[0].data(),
                     .shear_x_pa = channels_[1].data(),
                     .shear_y_pa = channels_[2].data(),
                     .x_m = nullptr,
                     .y_m = nullptr,
                     .size = kPillars};
    return patch_;
  }
  const TaxelLayout& layout() const { return layout_; }
  // Share of P that slips.
  double slipping() const {
    double all = 0, slips = 0;
    for (std::size_t i = 0; i < kPillars; ++i) {
      all += pressed_[i];
      if (std::hypot(load_[i].x, load_[i].y) > 0.999 * friction_ * pressed_[i]) slips += pressed_[i];
    }
    return slips / all;
  }

 private:
  struct Vector {
    double x = 0, y = 0;
  };
  // In pitches from the middle.
  static Vector place(std::size_t i) {
    return {static_cast<double>(i % kSide) - 2, static_cast<double>(i / kSide) - 2};
  }
  void hold() {
    for (std::size_t i = 0; i < kPillars; ++i) {
      const double limit = friction_ * pressed_[i], size = std::hypot(load_[i].x, load_[i].y);
      if (size > limit) load_[i] = {load_[i].x * limit / size, load_[i].y * limit / size};
    }
  }
  double noise() { return noise_n_ * std::sqrt(3.0) * random_.uniform(drawn_++, -1, 1); }

  TaxelLayout layout_ = TaxelLayout::grid(kSide, kSide, kPillarPitch_m);
  double friction_, noise_n_;
  std::array<double, kPillars> pressed_{};
  std::array<Vector, kPillars> load_{};
  std::array<std::array<float, kPillars>, 3> channels_{};
  ContactPatch patch_;
  RandomStream random_{7};
  std::uint64_t drawn_ = 0;
};

class PillarBedsTest : public ::testing::Test {
 protected:
  void follow(MovedPad& pad, int frames = 1) {
    for (int i = 0; i < frames; ++i) beds_.follow(pad.sense(), kBetween_s);
  }
  void pull(MovedPad& pad, const Way& all, int frames) {
    const auto part = static_cast<double>(frames);
    for (int i = 0; i < frames; ++i) {
      pad.move({all.x / part, all.y / part, all.turn / part});
      follow(pad);
    }
  }
  double best() const {
    std::size_t best = 0;
    for (std::size_t j = 0; j < kFrictions.size(); ++j)
      if (beds_.misfit(j) < beds_.misfit(best)) best = j;
    return kFrictions[best];
  }
  double misfit(double friction) const {
    const auto at = std::find(kFrictions.begin(), kFrictions.end(), friction);
    return beds_.misfit(static_cast<std::size_t>(at - kFrictions.begin()));
  }

  PillarBeds beds_{TaxelLayout::grid(kSide, kSide, kPillarPitch_m), kFrictions};
};

TEST_F(PillarBedsTest, KnowFrictionWhenAThirdOfThePressureSlips) {
  for (const double friction : {0.3, 0.5, 0.9}) {
    beds_.clear();
    MovedPad pad(friction);
    pad.press(0.5);
    follow(pad, 20);
    int frames = 0;
    for (; pad.slipping() < 0.33; ++frames) {
      pad.move({0.002, 0.001, 0});
      follow(pad);
    }
    EXPECT_GT(frames, 10);
    EXPECT_EQ(best(), friction);
    EXPECT_LT(misfit(friction), 2);
    for (const double other : kFrictions) {
      if (other == friction) continue;
      EXPECT_GT(misfit(other), misfit(friction) + 0.5) << other;
    }
  }
}

TEST_F(PillarBedsTest, KnowNothingOfAFrictionThatNoPillarNeeds) {
  MovedPad pad(0.9);
  pad.press(0.9);
  follow(pad, 20);
  pull(pad, {0.03, 0, 0}, 30);
  ASSERT_EQ(pad.slipping(), 0);
  for (const double friction : {0.7, 0.9, 1.2}) EXPECT_LT(misfit(friction), 0.1) << friction;
}

TEST_F(PillarBedsTest, FollowAContactThatIsPressedHarderAndPulledFurther) {
  MovedPad pad(0.5);
  pad.press(0.5);
  follow(pad, 20);
  pull(pad, {0.08, 0, 0}, 40);
  pad.press(0.9);
  follow(pad, 20);
  pull(pad, {0.25, 0, 0}, 60);
  ASSERT_GT(pad.slipping(), 0.1);
  EXPECT_EQ(best(), 0.5);
}

TEST_F(PillarBedsTest, FollowAPullThatGoesBack) {
  MovedPad pad(0.5);
  pad.press(0.5);
  follow(pad, 20);
  pull(pad, {0.14, 0, 0}, 40);
  pull(pad, {-0.2, 0, 0}, 40);
  EXPECT_EQ(best(), 0.5);
  EXPECT_LT(misfit(0.5), 2);
}

TEST_F(PillarBedsTest, FollowATurnWithThePull) {
  MovedPad pad(0.5);
  pad.press(0.5);
  follow(pad, 20);
  pull(pad, {0.06, 0.03, 0.09}, 60);
  ASSERT_GT(pad.slipping(), 0.2);
  EXPECT_EQ(best(), 0.5);
  EXPECT_LT(misfit(0.5), 2);
}

TEST_F(PillarBedsTest, SeeFrictionFallWherePillarsSlip) {
  MovedPad pad(0.9);
  pad.press(0.5);
  follow(pad, 20);
  pull(pad, {0.2, 0, 0}, 60);
  ASSERT_EQ(best(), 0.9);
  pad.set_friction(0.5);
  follow(pad, 10);
  ASSERT_GT(pad.slipping(), 0.3);
  EXPECT_GT(misfit(0.9), misfit(0.5) + 1) << "what was known is contradicted at once";
  pull(pad, {0.02, 0, 0}, 300);
  EXPECT_EQ(best(), 0.5) << "and what friction is now shows as the load goes on";
}

TEST_F(PillarBedsTest, TakeAContactThatWasNotSeenFromTheBeginningAsItIs) {
  MovedPad pad(0.5);
  pad.press(0.5);
  pad.move({0.14, 0, 0});
  beds_.lose_history();
  follow(pad);
  EXPECT_LT(misfit(0.5), 0.1);
  EXPECT_LT(misfit(1.2), 0.1) << "which pillars slip is not seen";
  EXPECT_GT(misfit(0.2), 1) << "but what they carry is";
}

TEST_F(PillarBedsTest, KnowFrictionThroughNoise) {
  int right = 0;
  for (int trial = 0; trial < 10; ++trial) {
    beds_.clear();
    MovedPad pad(0.5, 0.01);
    for (int skipped = 0; skipped < 97 * trial; ++skipped) pad.sense();
    pad.press(0.5);
    follow(pad, 20);
    std::array<double, kFrictions.size()> sums{};
    for (int i = 0; i < 100; ++i) {
      pad.move({0.0015, 0, 0});
      follow(pad);
      for (std::size_t j = 0; j < sums.size(); ++j) sums[j] += beds_.misfit(j);
    }
    right +=
        kFrictions[static_cast<std::size_t>(std::min_element(sums.begin(), sums.end()) - sums.begin())] ==
        0.5;
  }
  EXPECT_GE(right, 9);
}

TEST_F(PillarBedsTest, StayFiniteWhateverComes) {
  MovedPad pad(1.2);
  pad.press(0.5);
  follow(pad, 3);
  pull(pad, {1e6, -1e6, 1e5}, 3);
  pad.press(1e-9);
  follow(pad, 3);
  pad.press(-1);
  follow(pad, 3);
  for (const double friction : kFrictions) EXPECT_TRUE(std::isfinite(misfit(friction))) << friction;
}

TEST_F(PillarBedsTest, AllocateNothing) {
  MovedPad pad(0.5);
  pad.press(0.5);
  const auto before = test::allocations();
  follow(pad, 10);
  EXPECT_EQ(test::allocations(), before);
}

TEST(PillarBeds, AreOfFourToSixtyFourPillars) {
  EXPECT_THROW(PillarBeds(TaxelLayout::grid(3, 1, 0.002), kFrictions), std::invalid_argument);
  EXPECT_THROW(PillarBeds(TaxelLayout::grid(13, 5, 0.002), kFrictions), std::invalid_argument);
  EXPECT_NO_THROW(PillarBeds(TaxelLayout::grid(2, 2, 0.002), kFrictions));
  EXPECT_NO_THROW(PillarBeds(TaxelLayout::grid(4, 1, 0.002), kFrictions))
      << "in one row, which does not turn";
}

}  // namespace
}  // namespace slipd
