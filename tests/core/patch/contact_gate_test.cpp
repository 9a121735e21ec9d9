// When something touches a sensor of few taxels, whose zero wanders and whose taxels may be pulled.
#include "core/patch/contact_gate.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace slipd {
namespace {

constexpr double kPitch_m = 0.007;
constexpr std::int64_t kFrame_ns = 2'000'000;

class Gate : public ::testing::Test {
 protected:
  // One frame with the forces given in N, the first for each of nine taxels.
  bool sees(std::vector<double> normal_n, double shear_n, double noise_n = 0) {
    std::normal_distribution<double> noise(0, noise_n > 0 ? noise_n : 1e-12);
    normal_n.resize(9);
    for (std::size_t i = 0; i < 9; ++i) {
      p_[i] = static_cast<float>((normal_n[i] + noise(random_)) / layout_.area_m2());
      x_[i] = static_cast<float>((shear_n / 9 + noise(random_)) / layout_.area_m2());
      y_[i] = 0;
    }
    const Frame frame{.sequence = ++sequence_,
                      .time_ns = static_cast<std::int64_t>(sequence_) * kFrame_ns,
                      .normal_pa = p_,
                      .shear_x_pa = x_,
                      .shear_y_pa = y_,
                      .zeroed = true};
    finder_.set_noise(gate_.noise());
    return gate_.judge(frame, finder_.find(frame));
  }

  TaxelLayout layout_ = TaxelLayout::grid(3, 3, kPitch_m);
  PatchFinder finder_{layout_};
  FewTaxelsGate gate_{layout_, SensorClass::array3, default_min_normal_n(layout_)};
  std::mt19937_64 random_{2};
  std::vector<float> p_ = std::vector<float>(9), x_ = p_, y_ = p_;
  std::uint64_t sequence_ = 0;
};

TEST_F(Gate, IsPassedByTheLeastForceAndKeptDownToHalfOfIt) {
  EXPECT_FALSE(sees({0, 0, 0, 0, 0.09}, 0));
  EXPECT_TRUE(sees({0, 0, 0, 0, 0.11}, 0));
  EXPECT_TRUE(sees({0, 0, 0, 0, 0.06}, 0));
  EXPECT_FALSE(sees({0, 0, 0, 0, 0.04}, 0));
  EXPECT_FALSE(sees({0, 0, 0, 0, 0.06}, 0));
}

TEST_F(Gate, IsNotPassedByNoiseAboveTheLeastForce) {
  for (int i = 0; i < 3000; ++i) {
    const double wander_n = 0.05 * (i / 500 % 2);
    const bool seen = sees({wander_n}, 0, 0.015);
    EXPECT_FALSE(seen && i > 200) << i << ", after it was measured";
  }
  EXPECT_TRUE(gate_.noise());
  EXPECT_TRUE(sees({0, 0, 0, 0, 1}, 0, 0.015));
}

// What hooks on some taxels is no noise of the others.
TEST_F(Gate, SeesAContactThatPullsAtSomeTaxels) {
  for (int i = 0; i < 500; ++i) sees({}, 0, 0.005);
  EXPECT_TRUE(sees({-0.6, -0.4, 0, 0, 1, 1, 0, 0, 0}, 2, 0.005));
}

// A zero of another sensor, or counts that were shifted since it was taken.
TEST_F(Gate, KnowsAZeroThatIsAnothersByShearWithoutPressureSinceTheFirstFrame) {
  for (int i = 0; i < 50; ++i) {
    sees({}, 2, 0.005);
    EXPECT_TRUE(gate_.zero_is_anothers());
  }
  sees({0, 0, 0, 0, 3}, 2, 0.005);
  EXPECT_TRUE(gate_.zero_is_anothers()) << "pressure does not make it its own";
  sees({}, 0, 0.005);
  EXPECT_FALSE(gate_.zero_is_anothers()) << "a new zero was taken";
}

TEST_F(Gate, BelievesTheZeroOfASensorThatWasFreeBeforeSomethingPulls) {
  sees({}, 0, 0.005);
  sees({}, 2, 0.005);
  EXPECT_TRUE(gate_.pulled());
  EXPECT_FALSE(gate_.zero_is_anothers());
}

TEST_F(Gate, BelievesTheZeroOfASensorThatStartsInAGrip) {
  for (int i = 0; i < 50; ++i) sees({0, 0, 0, 0, 3}, 2, 0.005);
  sees({}, 2, 0.005);
  EXPECT_TRUE(gate_.pulled());
  EXPECT_FALSE(gate_.zero_is_anothers());
}

TEST_F(Gate, CallsShearWithoutPressurePulledAndNoContact) {
  for (int i = 0; i < 500; ++i) sees({}, 0, 0.005);
  EXPECT_FALSE(gate_.pulled());
  EXPECT_FALSE(sees({-0.5, -0.5, 0, 0, 0.5, 0.4, 0, 0, 0}, 3, 0.005));
  ASSERT_TRUE(gate_.pulled());
  EXPECT_NEAR(gate_.pulled()->shear_n, 3, 0.1);
  EXPECT_NEAR(gate_.pulled()->normal_n, -0.1, 0.1);
}

TEST(ContactGate, OfALargeArrayLeavesTheContactToItsNoise) {
  EXPECT_EQ(default_min_normal_n(TaxelLayout::grid(16, 16, 0.001)), 0);
  EXPECT_EQ(default_min_normal_n(TaxelLayout::grid(4, 4, 0.001)),
            default_min_normal_n(TaxelLayout::wrench(0.01)));
}

}  // namespace
}  // namespace slipd
