// Frames from the acquire thread to a recording. RecordTap is where a recording attaches its FrameQueue.
// While one is attached, the acquire thread copies each frame into it; the recording's thread takes them out.
// A frame for which the queue has no room is counted as missed; acquire never waits.
//
// The handshake of offer and detach, time running down. After detach the queue may be destroyed.
//
//   acquire: offer(frame)                  recording: detach()
//   queue_ -> q, not null
//   pushing_ = true  (seq_cst)
//   queue_ -> q      (seq_cst)
//                                          queue_ = null  (seq_cst)
//   q.push(frame)                          pushing_ -> true: waits
//   pushing_ = false (release)
//                                          pushing_ -> false: returns
//   next offer: queue_ -> null, returns
//
// Sequential consistency of the four accesses excludes that offer reads the queue and detach reads
// pushing_ = false: one of them comes second and sees the other's write.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <vector>

#include "core/frame/frame.hpp"

namespace slipd {

// A bounded queue of frames. Thread-safe between one producer (acquire) and one consumer (the recording).
class FrameQueue {
 public:
  // Allocates room for `frames` frames of `taxels` taxels. `frames` is at least 1.
  FrameQueue(std::size_t taxels, std::size_t frames);

  // Called from one thread: acquire. Copies the frame. A frame of another size, or without room, is counted
  // as missed. Wait-free.
  void push(const FrameSlot& frame) noexcept;
  // Called from one thread: the recording's. The oldest frame, or null. Valid until pop.
  const FrameSlot* front();
  // Called from one thread: the recording's. Gives the place of front() back; nothing if the queue is empty.
  void pop();

  // Called from any thread. Frames that were not queued.
  std::uint64_t missed() const noexcept { return missed_.load(std::memory_order_relaxed); }

 private:
  std::vector<float> memory_;
  std::vector<FrameSlot> slots_;
  boost::lockfree::spsc_queue<std::uint32_t> free_, filled_;  // indices into slots_
  std::atomic<std::uint64_t> missed_{0};                      // relaxed: a counter
};

// Thread-safe between one offering thread (acquire) and one attached recording.
class RecordTap {
 public:
  // Called from one thread: acquire. Queues the frame if a queue is attached; otherwise costs one load.
  void offer(const FrameSlot& frame) noexcept {
    if (queue_.load(std::memory_order_relaxed) == nullptr) return;
    // Sequentially consistent, like the two accesses in detach: see the drawing above.
    pushing_.store(true, std::memory_order_seq_cst);
    if (FrameQueue* queue = queue_.load(std::memory_order_seq_cst)) queue->push(frame);
    pushing_.store(false, std::memory_order_release);  // pairs with the load in detach: the frame is queued
  }

  // Called from any thread but acquire. False: another queue is attached. `queue` must live until detach
  // returned.
  bool attach(FrameQueue& queue) noexcept {
    // Pairs with the load in offer, so that acquire sees the constructed queue.
    FrameQueue* none = nullptr;
    return queue_.compare_exchange_strong(none, &queue, std::memory_order_seq_cst);
  }

  // Called from the recording that attached. Waits for a push under way, the copy of one frame at most. The
  // acquire thread does not touch the queue afterwards.
  void detach() noexcept;

 private:
  std::atomic<FrameQueue*> queue_{nullptr};
  std::atomic<bool> pushing_{false};
};

}  // namespace slipd
