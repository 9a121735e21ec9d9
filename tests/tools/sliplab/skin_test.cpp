#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/contact/contact_field.hpp"
#include "tests/support/synthetic.hpp"
#include "tools/sliplab/skin/depth.hpp"
#include "tools/sliplab/skin/shear_order.hpp"

namespace sliplab {
namespace {

using namespace slipd;

// Presses of 1 to 4 N with a light pull on a 16 x 16 pad of +-8 mm, with noise of 0.5 % of the peak.
class Presses {
 public:
  explicit Presses(double depth_m, double gain_spread = 0,
                   std::optional<double> bonded_poisson = std::nullopt)
      : layout_(TaxelLayout::grid(16, 16, 0.001)),
        sheet_(layout_, {.depth_m = depth_m, .bonded_poisson = bonded_poisson}) {
    std::normal_distribution<double> normal(1, gain_spread);
    for (std::size_t i = 0; i < layout_.size(); ++i)
      gain_.push_back(gain_spread > 0 ? static_cast<float>(normal(random_)) : 1.0F);
  }

  PressFrame press() {
    const std::size_t n = layout_.size();
    PressFrame frame{std::vector<float>(n), std::vector<float>(n), std::vector<float>(n)};
    constexpr double kFriction = 0.5;
    const double force_n = 1 + 3 * unit();
    contact::LoadHistory contact(synthetic::paper_pair());
    contact.move_to(force_n, 0, kFriction);
    contact.move_to(force_n, 0.2 * kFriction * force_n, kFriction);
    sheet_.sense(contact, 0.002 * (unit() - 0.5), 0.002 * (unit() - 0.5), 6.28 * unit(), frame.normal_pa,
                 frame.shear_x_pa, frame.shear_y_pa);
    const float peak = *std::max_element(frame.normal_pa.begin(), frame.normal_pa.end());
    for (auto* channel : {&frame.normal_pa, &frame.shear_x_pa, &frame.shear_y_pa}) {
      for (std::size_t i = 0; i < n; ++i)
        (*channel)[i] = gain_[i] * (*channel)[i] + 0.005F * peak * static_cast<float>(2 * unit() - 1);
    }
    return frame;
  }
  std::vector<PressFrame> some(std::size_t count) {
    std::vector<PressFrame> out;
    for (std::size_t i = 0; i < count; ++i) out.push_back(press());
    return out;
  }
  const TaxelLayout& layout() const { return layout_; }

 private:
  double unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }

  TaxelLayout layout_;
  contact::ContactField sheet_;
  std::mt19937_64 random_{7};
  std::vector<float> gain_;
};

constexpr Range kFriction{0.1, 0.9};

TEST(SkinDepth, IsFoundWithinItsDeviation) {
  for (const double depth_m : {0.0005, 0.001, 0.002}) {
    Presses presses(depth_m);
    const auto found = skin_depth(presses.layout(), kFriction, presses.some(8));
    ASSERT_TRUE(found) << depth_m;
    EXPECT_EQ(found->frames, 8U);
    EXPECT_NEAR(found->depth_m, depth_m, 4 * found->sigma_m + 0.005 * depth_m);
    EXPECT_LT(found->sigma_m, 0.1 * depth_m);
    EXPECT_GT(found->sigma_m, 0);
  }
}

TEST(SkinDepth, IsFoundOnARigidBaseWhichIsLikelierThanAHalfSpaceAndTheOtherWayRound) {
  for (const std::optional<double> bonded_poisson : {std::optional(0.45), std::optional<double>()}) {
    Presses presses(0.001, 0, bonded_poisson);
    const std::vector<PressFrame> some = presses.some(6);
    const auto rigid = skin_depth(presses.layout(), kFriction, some, 0.45),
               half_space = skin_depth(presses.layout(), kFriction, some);
    ASSERT_TRUE(rigid && half_space);
    const auto &right = bonded_poisson ? rigid : half_space, &wrong = bonded_poisson ? half_space : rigid;
    EXPECT_NEAR(right->depth_m, 0.001, 4 * right->sigma_m + 5e-6);
    EXPECT_LT(right->misfit_nats, wrong->misfit_nats - 6 * 2);
  }
}

TEST(SkinDepth, OfTaxelsAtTheSurfaceIsNone) {
  Presses presses(0);
  const auto found = skin_depth(presses.layout(), kFriction, presses.some(4));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->depth_m, 0);
}

TEST(SkinDepth, ComesWithTheSpreadOfGains) {
  Presses even(0.001), uneven(0.001, 0.05);
  const auto small = skin_depth(even.layout(), kFriction, even.some(8)),
             large = skin_depth(uneven.layout(), kFriction, uneven.some(8));
  ASSERT_TRUE(small && small->gain_spread && large && large->gain_spread);
  EXPECT_LT(*small->gain_spread, 0.01);
  EXPECT_NEAR(*large->gain_spread, 0.05, 0.015);
}

TEST(PressFrames, LeaveOutLightAndEmptyFrames) {
  Presses presses(0.001);
  std::vector<PressFrame> frames = presses.some(6);
  const std::vector<float> nothing(presses.layout().size());
  for (int i = 0; i < 20; ++i) frames.push_back({nothing, nothing, nothing});
  EXPECT_LE(press_frames(presses.layout(), frames, 40).size(), 6U);
  EXPECT_GE(press_frames(presses.layout(), frames, 40).size(), 2U);
  EXPECT_EQ(press_frames(presses.layout(), frames, 2).size(), 2U);
}

template <typename Change>
ShearOrderVerdict verdict_on(double depth_m, const Change& change) {
  Presses presses(depth_m);
  PatchFinder finder(presses.layout());
  ShearOrder order;
  for (int i = 0; i < 4; ++i) {
    PressFrame frame = presses.press();
    change(frame);
    order.add(presses.layout(), finder.find({1, 1, frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa}));
  }
  return order.verdict();
}

void reverse(std::vector<float>& values) {
  for (float& value : values) value = -value;
}

TEST(ShearOrders, OfAPressShowSignsAndOrder) {
  EXPECT_EQ(verdict_on(0.001, [](PressFrame&) {}), ShearOrderVerdict::outward);
  EXPECT_EQ(verdict_on(0.001, [](PressFrame& f) { reverse(f.shear_x_pa); }), ShearOrderVerdict::x_reversed);
  EXPECT_EQ(verdict_on(0.001, [](PressFrame& f) { reverse(f.shear_y_pa); }), ShearOrderVerdict::y_reversed);
  EXPECT_EQ(verdict_on(0.001,
                       [](PressFrame& f) {
                         reverse(f.shear_x_pa);
                         reverse(f.shear_y_pa);
                       }),
            ShearOrderVerdict::both_reversed);
  EXPECT_EQ(verdict_on(0.001, [](PressFrame& f) { std::swap(f.shear_x_pa, f.shear_y_pa); }),
            ShearOrderVerdict::transposed);
  EXPECT_EQ(verdict_on(0.001,
                       [](PressFrame& f) {
                         std::swap(f.shear_x_pa, f.shear_y_pa);
                         reverse(f.shear_y_pa);
                       }),
            ShearOrderVerdict::turned);
}

TEST(ShearOrders, OfTaxelsAtTheSurfaceAreUnclear) {
  EXPECT_EQ(verdict_on(0, [](PressFrame&) {}), ShearOrderVerdict::unclear);
}

}  // namespace
}  // namespace sliplab
