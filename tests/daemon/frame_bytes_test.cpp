#include "daemon/rpc/methods/frame_bytes.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace slipd {
namespace {

TEST(FrameBytes, HaveEachValueToWithinHalfAStep) {
  std::vector<float> normal, x, y;
  constexpr std::size_t kTaxels = 50;
  for (std::size_t i = 0; i < kTaxels; ++i) {
    normal.push_back(static_cast<float>(1000 * i + 10));
    x.push_back(static_cast<float>(i) - 30.5F);
    y.push_back(0.7F * static_cast<float>(i));
  }
  const FrameBytes bytes = frame_bytes(normal, x, y);
  ASSERT_EQ(bytes.values.size(), 3 * kTaxels);
  const double peak = bytes.peak_pa, shear = bytes.peak_shear_pa;
  EXPECT_EQ(peak, normal.back());
  EXPECT_EQ(shear, y.back());
  for (std::size_t i = 0; i < kTaxels; ++i) {
    const auto pressure = static_cast<unsigned char>(bytes.values[i]);
    EXPECT_NEAR(pressure / 255. * peak, normal[i], peak / 509);
    EXPECT_NEAR(static_cast<signed char>(bytes.values[kTaxels + i]) / 127. * shear, x[i], shear / 253);
    EXPECT_NEAR(static_cast<signed char>(bytes.values[2 * kTaxels + i]) / 127. * shear, y[i], shear / 253);
  }
}

TEST(FrameBytes, OfValuesThatAreNoNumbersAreZeros) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kFar = std::numeric_limits<float>::infinity();
  const FrameBytes bytes =
      frame_bytes(std::vector{kNan, 2.F, -1.F}, std::vector{kFar, -kFar, 1.F}, std::vector{0.F, 0.F, kNan});
  EXPECT_EQ(bytes.peak_pa, 2);
  EXPECT_EQ(bytes.values, std::string({0, '\xff', 0, 0, 0, 127, 0, 0, 0}));
}

TEST(FrameBytes, OfAFrameOfNothingAreZeros) {
  constexpr float kLeast = std::numeric_limits<float>::denorm_min();
  EXPECT_EQ(frame_bytes(std::vector{0.F}, std::vector{0.F}, std::vector{0.F}).values, std::string(3, '\0'));
  EXPECT_EQ(frame_bytes(std::vector{kLeast}, std::vector{kLeast}, std::vector{0.F}).values,
            std::string(3, '\0'));
  EXPECT_EQ(frame_bytes({}, {}, {}).values, "");
}

}  // namespace
}  // namespace slipd
