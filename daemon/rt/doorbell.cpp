#include "daemon/rt/doorbell.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <ctime>

namespace slipd {
namespace {

long futex(std::atomic<std::uint32_t>& word, int operation, std::uint32_t value,
           const timespec* until) noexcept {
  static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t));
  return syscall(SYS_futex, &word, operation, value, until, nullptr, FUTEX_BITSET_MATCH_ANY);
}

}  // namespace

void Doorbell::wake_waiter() noexcept {
  futex(count_, FUTEX_WAKE_PRIVATE, 1, nullptr);
}

bool Doorbell::wait(std::uint32_t seen, Clock::time_point until) noexcept {
  using std::chrono::duration_cast;
  using std::chrono::nanoseconds;
  using std::chrono::seconds;
  // FUTEX_WAIT_BITSET takes CLOCK_MONOTONIC, which steady_clock is.
  const auto since_boot = until.time_since_epoch();
  timespec deadline{};
  deadline.tv_sec = static_cast<time_t>(duration_cast<seconds>(since_boot).count());
  deadline.tv_nsec = static_cast<long>((duration_cast<nanoseconds>(since_boot) % seconds(1)).count());
  // Sequentially consistent: either ring() sees sleeping_, or this thread sees the new count.
  sleeping_.store(true, std::memory_order_seq_cst);
  bool rung = count_.load(std::memory_order_seq_cst) != seen;
  if (!rung) {
    futex(count_, FUTEX_WAIT_BITSET_PRIVATE, seen, &deadline);
    rung = count_.load(std::memory_order_acquire) != seen || Clock::now() < until;
  }
  sleeping_.store(false, std::memory_order_relaxed);  // waking nobody does no harm
  return rung;
}

}  // namespace slipd
