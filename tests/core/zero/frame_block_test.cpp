// A block of frames is its frames' mean and variance, at any offset.
#include "core/zero/frame_block.hpp"

#include <gtest/gtest.h>

#include "tests/core/zero/raw_sensor.hpp"

namespace slipd {
namespace {

TEST(FrameBlock, IsTheMeanAndVarianceOfItsFramesAtAnyOffset) {
  test::RawSensor sensor(TaxelLayout::grid(4, 3, 0.002));
  FrameBlock block(12);
  std::vector<double> sum(36), squares(36);
  int frames = 0;
  for (bool whole = false; !whole; ++frames) {
    const FrameSlot slot = sensor.read();
    const std::span<const float> channels[] = {slot.normal_pa, slot.shear_x_pa, slot.shear_y_pa};
    for (std::size_t i = 0; i < 36; ++i) {
      const double value = channels[i / 12][i % 12];
      sum[i] += value;
      squares[i] += value * value;
    }
    whole = block.add(slot);
  }
  EXPECT_EQ(block.frames(), static_cast<std::uint32_t>(frames));
  EXPECT_GE(block.ended_ns() - block.begun_ns(), FrameBlock::kDurationNs);
  for (std::size_t i = 0; i < 36; ++i) {
    const double mean = sum[i] / frames;
    const double variance = (squares[i] - frames * mean * mean) / (frames - 1);
    EXPECT_NEAR(block.mean_pa()[i], mean, 0.05) << "floats of 30000 have steps of 0.002";
    EXPECT_NEAR(block.variance_pa2()[i] / variance, 1, 1e-3);
  }
}

TEST(FrameBlock, HasEnoughFramesOfASlowSensorAndIsLongEnoughForAFastOne) {
  for (const std::int64_t period_ns : {std::int64_t{100'000'000}, std::int64_t{100'000}}) {
    FrameBlock block(1);
    std::vector<float> memory(3);
    FrameSlot slot;
    slot.normal_pa = std::span(memory).first(1);
    slot.shear_x_pa = std::span(memory).subspan(1, 1);
    slot.shear_y_pa = std::span(memory).last(1);
    do slot.time_ns += period_ns;
    while (!block.add(slot));
    EXPECT_GE(block.frames(), FrameBlock::kFrames);
    EXPECT_GE(block.ended_ns() - block.begun_ns(), FrameBlock::kDurationNs);
    EXPECT_TRUE(block.frames() == FrameBlock::kFrames || block.frames() == 1001) << block.frames();
  }
}

}  // namespace
}  // namespace slipd
