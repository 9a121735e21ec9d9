// Whose turn it is to estimate. All that the estimate loop writes has one writer at a time: the estimate
// thread, or an acquire thread that estimates the frame it has just delivered, so that nobody has to be woken
// for it. Nobody waits for the turn: who does not get it leaves a request, and who has it looks once more or
// wakes the estimate thread.
//
// One word counts the requests since the turn was taken, and has a flag for the estimate thread's; 0: nobody
// has the turn. Time runs down.
//
//   acquire of a                      word   acquire of b
//   publishes its frame
//   ask -> 1st: has the turn           1
//   estimates a                        .     publishes its frame
//   .                                  2     ask -> not the 1st: goes on reading
//   done(1) -> false: 2 requests       2
//   looks at all sensors: estimates b  2
//   done(2) -> true                    0
#pragma once

#include <atomic>
#include <cstdint>

namespace slipd {

// Thread-safe. `Atomic` is std::atomic except in the memory-model test.
template <template <typename> class Atomic = std::atomic>
class EstimateTurn {
 public:
  // Called from acquire threads, after they published a frame. True: the caller has the turn, and `seen` is
  // what it gives to done(). False: who has the turn looks at all sensors, or the estimate thread does.
  // Wait-free.
  bool ask(std::uint64_t& seen) noexcept {
    // Acquire: pairs with the release in done and hand_over. Release: pairs with the acquire in done, so that
    // who has the turn sees the frame. All changes are read-modify-writes, so each release reaches
    // all who read a later value. 63 bits of requests are never used up.
    const std::uint64_t before = word_.fetch_add(1, std::memory_order_acq_rel);
    seen = before + 1;
    return before == 0;
  }

  // Called from one thread: estimate. True: it has the turn. False: its doorbell is rung when the turn is
  // free. Wait-free.
  bool ask_for_thread(std::uint64_t& seen) noexcept {
    // As in ask. A flag, since it asks again and again while another thread has the turn.
    const std::uint64_t before = word_.fetch_or(kThread, std::memory_order_acq_rel);
    seen = before | kThread;
    return before == 0;
  }

  // Called by who has the turn, when it has looked at all that was requested up to `seen`. True: the turn is
  // free. False: there are more requests, up to the new `seen`, and the caller still has the turn.
  bool done(std::uint64_t& seen) noexcept {
    // Release: pairs with the acquire of the next ask, so that the next turn sees all that this one wrote.
    // Acquire, if it fails: pairs with the release of the requests, so that their frames are seen.
    return word_.compare_exchange_strong(seen, 0, std::memory_order_acq_rel, std::memory_order_acquire);
  }

  // Called by who has the turn. Frees it whatever was requested. The estimate thread then has to look at all
  // sensors.
  // Release: pairs with the acquire of the next ask, as in done.
  void hand_over() noexcept { word_.exchange(0, std::memory_order_acq_rel); }

  // Whether the estimate thread is among the requests up to `seen`.
  static bool thread_asks(std::uint64_t seen) noexcept { return seen >= kThread; }

 private:
  static constexpr std::uint64_t kThread = std::uint64_t{1} << 63U;

  Atomic<std::uint64_t> word_{0};
};

}  // namespace slipd
