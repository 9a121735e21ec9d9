// The last frames of one sensor and what was estimated from each, in memory that is taken once. One thread at
// a time.
#pragma once

#include <optional>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/storage/recording.hpp"

namespace slipd {

class FrameHistory {
 public:
  FrameHistory(std::size_t taxels, std::size_t frames);  // at least one frame

  void push(const FrameSlot& frame) noexcept;  // of as many taxels; the oldest goes when there is no room
  std::size_t size() const noexcept { return size_; }
  const FrameSlot& operator[](std::size_t age_rank) const noexcept;  // 0: the oldest

  // Of the frame of that time, which was pushed before; the first one stays. Nothing if it is not there.
  void note(std::int64_t time_ns, const RecordedEstimate& estimate) noexcept;
  const RecordedEstimate* estimate(std::size_t age_rank) const noexcept;  // null: none is known

  static std::size_t bytes_of_frame(std::size_t taxels) noexcept;  // that one frame takes

 private:
  std::size_t place(std::size_t age_rank) const noexcept;
  std::vector<float> memory_;
  std::vector<FrameSlot> slots_;
  std::vector<std::optional<RecordedEstimate>> estimates_;  // of each slot
  std::size_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace slipd
