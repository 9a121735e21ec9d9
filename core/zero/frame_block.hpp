// Some consecutive frames of one sensor as mean and variance of each channel (docs/methods.md §33): long
// enough that noise cancels, short enough that a hand does not come and go unseen.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/frame/frame.hpp"

namespace slipd {

class FrameBlock {
 public:
  // At least so many frames over at least so long.
  static constexpr std::uint32_t kFrames = 16;
  static constexpr std::int64_t kDurationNs = 100'000'000;

  explicit FrameBlock(std::size_t taxels);

  // Acquire thread, as all of it. Adds a frame; true if the block is whole with it: then mean_pa and
  // variance_pa2 are set, and the next frame begins the next one.
  bool add(const FrameSlot& frame) noexcept;
  // The frames of the block that is under way, and the last whole one.
  void forget() noexcept { count_ = frames_ = 0; }

  // Mean of the frames of the block that is under way, else of the last whole one, into `mean_pa`, which has
  // three values a taxel. False: there is neither.
  bool newest_mean(std::span<float> mean_pa) const noexcept;

  // Of the last whole block; three values a taxel, as in Bias.
  std::span<const float> mean_pa() const noexcept { return mean_; }
  std::span<const float> variance_pa2() const noexcept { return variance_; }  // of one frame
  std::uint32_t frames() const noexcept { return frames_; }
  std::int64_t begun_ns() const noexcept { return begun_ns_; }
  std::int64_t ended_ns() const noexcept { return ended_ns_; }

 private:
  void finish() noexcept;

  // Sums are taken of differences from the block's first frame, so that an offset of any size costs no
  // digits.
  std::vector<float> first_, sum_, squares_, mean_, variance_;
  std::uint32_t count_ = 0, frames_ = 0;
  std::int64_t first_ns_ = 0, last_ns_ = 0, begun_ns_ = 0, ended_ns_ = 0;
};

}  // namespace slipd
