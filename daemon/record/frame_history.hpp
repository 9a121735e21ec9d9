// The last frames of one sensor and their estimates, a ring buffer in memory that is allocated once.
#pragma once

#include <optional>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/recording/recording.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: the flight recorder's.
class FrameHistory {
 public:
  // Allocates room for `frames` frames, at least one, of `taxels` taxels.
  FrameHistory(std::size_t taxels, std::size_t frames);

  // Appends a frame with the same number of taxels. Replaces the oldest when full.
  void push(const FrameSlot& frame) noexcept;
  // Number of frames.
  std::size_t size() const noexcept { return size_; }
  // The frame at this place; 0: the oldest. `age_rank` < size().
  const FrameSlot& operator[](std::size_t age_rank) const noexcept;

  // Attaches an estimate to the frame with this time, ns, unless it has one. Without effect if there is no
  // such frame.
  void attach_estimate(std::int64_t time_ns, const RecordedEstimate& estimate) noexcept;
  // The estimate of the frame at this place; null: it has none.
  const RecordedEstimate* estimate(std::size_t age_rank) const noexcept;

  // Memory that one frame takes, bytes.
  static std::size_t bytes_of_frame(std::size_t taxels) noexcept;

 private:
  std::size_t slot_index(std::size_t age_rank) const noexcept;
  std::vector<float> memory_;
  std::vector<FrameSlot> slots_;
  std::vector<std::optional<RecordedEstimate>> estimates_;  // of each slot
  std::size_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace slipd
