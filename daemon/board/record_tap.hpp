// Frames on their way into a recording: acquire copies each one that it delivers into a queue of whole
// frames, if there is one; a writer thread takes them out. What finds no room is counted, never waited for.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <vector>

#include "core/frame/frame.hpp"

namespace slipd {

class FrameQueue {
 public:
  FrameQueue(std::size_t taxels, std::size_t frames);

  void push(const FrameSlot& frame) noexcept;  // acquire thread. A frame of another size is counted as missed
  const FrameSlot* front();                    // writer thread: the oldest, or null
  void pop();                                  // writer thread: done with front()

  std::uint64_t missed() const noexcept { return missed_.load(std::memory_order_relaxed); }

 private:
  std::vector<float> memory_;
  std::vector<FrameSlot> slots_;
  boost::lockfree::spsc_queue<std::uint32_t> free_, filled_;  // indices of slots_
  std::atomic<std::uint64_t> missed_{0};                      // relaxed: a number of its own
};

class RecordTap {
 public:
  // Acquire thread. Nothing but a load while nobody records.
  void offer(const FrameSlot& frame) noexcept {
    if (queue_.load(std::memory_order_relaxed) == nullptr) return;
    // Sequentially consistent, as are the two in detach: either detach sees that we are in here, or we see no
    // queue.
    inside_.store(true, std::memory_order_seq_cst);
    if (FrameQueue* queue = queue_.load(std::memory_order_seq_cst)) queue->push(frame);
    inside_.store(false, std::memory_order_release);  // pairs with the load in detach: the frame is pushed
  }

  // io or writer thread. False: another recording has it.
  bool attach(FrameQueue& queue) noexcept {
    // Pairs with the load in offer that hands the queue to push: it is whole there.
    FrameQueue* none = nullptr;
    return queue_.compare_exchange_strong(none, &queue, std::memory_order_seq_cst);
  }

  // Whoever attached. After it the queue is touched by its writer only.
  void detach() noexcept;

 private:
  std::atomic<FrameQueue*> queue_{nullptr};
  std::atomic<bool> inside_{false};
};

}  // namespace slipd
