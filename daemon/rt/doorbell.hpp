// How one thread waits for another without a lock: a futex. Ringing costs two atomic operations when nobody
// sleeps, and one system call when somebody does. Any number may ring, one waits.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace slipd {

class Doorbell {
 public:
  using Clock = std::chrono::steady_clock;

  // The waiter: how often it has rung so far. To be read before looking for work. Acquire: pairs with ring(),
  // whose news is found.
  std::uint32_t rung() const noexcept { return count_.load(std::memory_order_acquire); }

  // Any thread, after its news is in place. Never blocks.
  void ring() noexcept {
    // Sequentially consistent, as are the two in wait: either the waiter sees the new count, or we see that
    // it sleeps.
    count_.fetch_add(1, std::memory_order_seq_cst);
    if (sleeping_.load(std::memory_order_seq_cst)) wake();
  }

  // The waiter: returns once it has rung more than `seen` times, or at `until`. May return early; false means
  // `until`.
  bool wait(std::uint32_t seen, Clock::time_point until) noexcept;

 private:
  void wake() noexcept;
  std::atomic<std::uint32_t> count_{0};
  std::atomic<bool> sleeping_{false};
};

}  // namespace slipd
