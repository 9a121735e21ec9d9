// slipd's end of the shared memory that holds the values of large frames. A writer may do to it what it likes
// at any time, but change its size: it is sealed, so that reading never raises SIGBUS. slipd believes nothing
// in it. How large it is and which slot is read follow from what slipd keeps itself and from the notice,
// which the kernel has copied; a slot's number is compared, and values are read once each.
//
// One frame, time running down:
//
//   writer                                 slipd
//   slot.frame = 0
//   values
//   slot.frame = 5
//   sends the notice of 5        ------->  receives it
//                                          slot.frame -> 5
//                                          reads the values
//   (a wrong writer: slot.frame = 0)
//                                          slot.frame -> 0, not 5: the frame is torn
//                                          taken = 5: the slot may be filled again
//
// Acquire thread. Nothing allocates from the heap or throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/storage/unique_fd.hpp"
#include "push_layout/layout.hpp"

namespace slipd::push {

class FrameRing {
 public:
  // No memory: false as a bool.
  FrameRing() = default;
  // Memory for frames whose values have this many bytes; none if the kernel has none to give.
  explicit FrameRing(std::size_t values_bytes) noexcept;
  FrameRing(FrameRing&& other) noexcept { swap(other); }
  FrameRing& operator=(FrameRing&& other) noexcept {
    swap(other);
    return *this;
  }
  ~FrameRing();

  // For the writer; negative: none, or given up.
  int descriptor() const noexcept { return file_.get(); }
  // The writer has its own copy.
  void close_descriptor() noexcept { file_ = UniqueFd(); }

  explicit operator bool() const noexcept { return memory_ != nullptr; }
  std::size_t values_bytes() const noexcept { return values_bytes_; }

  // Whether the values of this frame are whole at the moment.
  bool holds(std::uint64_t frame) const noexcept;
  // Where they are. Whether what was read there is one frame, holds() says afterwards.
  const std::uint8_t* values(std::uint64_t frame) const noexcept;
  // The writer may fill the slot again.
  void give_back(std::uint64_t frame) noexcept;

 private:
  void swap(FrameRing& other) noexcept {
    std::swap(file_, other.file_);
    std::swap(memory_, other.memory_);
    std::swap(values_bytes_, other.values_bytes_);
  }
  push_layout::RingSlot& slot(std::uint64_t frame) const noexcept;

  UniqueFd file_;
  std::byte* memory_ = nullptr;
  std::size_t values_bytes_ = 0;
};

}  // namespace slipd::push
