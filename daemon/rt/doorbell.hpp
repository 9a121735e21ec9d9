// Wakes one thread from others without a lock, by a futex. Ringing costs two atomic operations while the
// waiter runs, and one system call while it sleeps.
//
// The waiter's loop:
//   const auto seen = bell.ring_count();   // before it looks for work: a later ring ends the wait
//   ... looks for work ...
//   bell.wait(seen, deadline);
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace slipd {

// Thread-safe between any number of ringing threads and one waiting thread.
class Doorbell {
 public:
  using Clock = std::chrono::steady_clock;

  // Called from one thread: the waiter. How often it was rung so far.
  std::uint32_t ring_count() const noexcept {
    // Acquire: pairs with ring(), so that what was written before the ring is seen.
    return count_.load(std::memory_order_acquire);
  }

  // Called from any thread, after it wrote what the waiter is to find. Never blocks.
  void ring() noexcept {
    // Sequentially consistent, like the two accesses in wait: either the waiter sees the new count, or this
    // thread sees that the waiter sleeps.
    count_.fetch_add(1, std::memory_order_seq_cst);
    if (sleeping_.load(std::memory_order_seq_cst)) wake_waiter();
  }

  // Called from one thread: the waiter. Returns when the count is no longer `seen`, or at `until`. May return
  // early. Returns false only at `until`.
  bool wait(std::uint32_t seen, Clock::time_point until) noexcept;

 private:
  void wake_waiter() noexcept;
  std::atomic<std::uint32_t> count_{0};
  std::atomic<bool> sleeping_{false};
};

}  // namespace slipd
