// Noise of one channel alone is noticed, vibrations of all and loads are not.
#include "core/health/noise_jump.hpp"

#include <gtest/gtest.h>

#include <array>

namespace slipd {
namespace {

constexpr std::size_t kProbes = 100, kTurning = 66;

// Noise of these mean squared steps, Pa^2.
NoiseJump::Channels noise(double normal_pa2, double shear_x_pa2, double shear_y_pa2,
                          std::size_t turning = kTurning) {
  NoiseJump::Channels channels;
  const std::array squares{normal_pa2, shear_x_pa2, shear_y_pa2};
  for (std::size_t c = 0; c < channels.size(); ++c) {
    channels[c].change = {kProbes, kProbes, turning};
    channels[c].step_square_pa2 = squares[c];
  }
  return channels;
}

class ANoiseJump : public ::testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 100; ++i) ASSERT_FALSE(jump_.update(noise(1, 1, 1), true));
  }
  // Whether one of ten such frames is called noisy.
  bool noticed(const NoiseJump::Channels& channels) {
    bool any = false;
    for (int i = 0; i < 10; ++i) any = jump_.update(channels, true) || any;
    return any;
  }
  NoiseJump jump_;
};

TEST_F(ANoiseJump, OfOneChannelIsNoticed) {
  EXPECT_TRUE(noticed(noise(1, 100, 1)));
}

TEST_F(ANoiseJump, OfOneFrameIsNot) {
  EXPECT_FALSE(jump_.update(noise(1, 100, 1), true));
  EXPECT_FALSE(noticed(noise(1, 1, 1)));
}

TEST_F(ANoiseJump, OfAllChannelsIsAVibration) {
  EXPECT_FALSE(noticed(noise(100, 100, 100)));
}

TEST_F(ANoiseJump, IsNotALoadThatDoesNotTurn) {
  EXPECT_FALSE(noticed(noise(1, 100, 1, 10)));
}

TEST_F(ANoiseJump, IsNotNoticedInANewContact) {
  jump_.update(noise(1, 1, 1), false);
  EXPECT_FALSE(noticed(noise(1, 100, 1)));
}

}  // namespace
}  // namespace slipd
