// The last frames of one sensor, in memory that is taken once. One thread at a time.
#pragma once

#include <vector>

#include "core/frame/frame.hpp"

namespace slipd {

class FrameHistory {
 public:
  FrameHistory(std::size_t taxels, std::size_t frames);  // at least one frame

  void push(const FrameSlot& frame) noexcept;  // of as many taxels; the oldest goes when there is no room
  std::size_t size() const noexcept { return size_; }
  const FrameSlot& operator[](std::size_t age_rank) const noexcept;  // 0: the oldest

 private:
  std::vector<float> memory_;
  std::vector<FrameSlot> slots_;
  std::size_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace slipd
