// Whose turn it is to estimate: one thread's at a time, and no frame is left lying.
#include "daemon/pipeline/estimate_turn.hpp"

#include <gtest/gtest.h>

#include <array>
#include <thread>
#include <vector>

#include "daemon/rt/doorbell.hpp"

namespace slipd {
namespace {

TEST(EstimateTurn, IsTakenByOneAndFreedWhenNothingElseWasRequested) {
  EstimateTurn<> turn;
  std::uint64_t first = 0, second = 0;
  ASSERT_TRUE(turn.ask(first));
  EXPECT_FALSE(turn.ask(second));
  EXPECT_FALSE(turn.done(first)) << "a frame came meanwhile";
  EXPECT_FALSE(EstimateTurn<>::thread_asks(first));
  EXPECT_TRUE(turn.done(first));
  EXPECT_TRUE(turn.ask(second));
}

TEST(EstimateTurn, TellsThatTheThreadAsksHoweverOftenItDoes) {
  EstimateTurn<> turn;
  std::uint64_t own = 0, ignored = 0;
  ASSERT_TRUE(turn.ask(own));
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(turn.ask_for_thread(ignored));
  EXPECT_FALSE(turn.done(own));
  EXPECT_TRUE(EstimateTurn<>::thread_asks(own));
  turn.hand_over();
  EXPECT_TRUE(turn.ask_for_thread(own));
  EXPECT_TRUE(turn.done(own));
}

// As the estimate loop does it: threads deliver frames and estimate all that they find while they have the
// turn; one thread, which is rung, does what they leave. The counters of what was taken are no atomics, so
// that ThreadSanitizer sees two threads with the turn.
TEST(EstimateTurn, LeavesNoFrameWhenManyThreadsDeliver) {
  constexpr std::size_t kThreads = 4;
  constexpr std::uint64_t kFrames = 20'000;
  struct Sensor {
    std::atomic<std::uint64_t> delivered{0};
    std::uint64_t taken = 0;
  };
  std::array<Sensor, kThreads> sensors;
  EstimateTurn<> turn;
  Doorbell bell;
  std::atomic<bool> stop{false};
  const auto take_all = [&] {
    for (Sensor& sensor : sensors) sensor.taken = sensor.delivered.load(std::memory_order_relaxed);
  };
  std::jthread thread([&] {
    for (;;) {
      const auto rung = bell.ring_count();
      const bool ends = stop.load(std::memory_order_relaxed);
      std::uint64_t seen = 0;
      bool again = false;
      if (turn.ask_for_thread(seen)) {
        if (ends) return;
        take_all();
        again = !turn.done(seen);
        if (again) turn.hand_over();
      }
      if (!again) bell.wait(rung, Doorbell::Clock::now() + std::chrono::hours(1));
    }
  });
  {
    std::vector<std::jthread> devices;
    for (Sensor& sensor : sensors) {
      devices.emplace_back([&] {
        for (std::uint64_t i = 1; i <= kFrames; ++i) {
          // Relaxed: the turn orders it.
          sensor.delivered.store(i, std::memory_order_relaxed);
          std::uint64_t seen = 0;
          if (!turn.ask(seen)) continue;
          for (int looks = 0;; ++looks) {
            take_all();
            if (turn.done(seen)) break;
            if (looks < 2 && !EstimateTurn<>::thread_asks(seen)) continue;
            turn.hand_over();
            bell.ring();
            break;
          }
        }
      });
    }
  }
  // What is left was handed over to the thread, which the bell has woken or wakes before it sees `stop`.
  std::uint64_t seen = 0;
  while (!turn.ask(seen)) std::this_thread::yield();
  std::uint64_t sum = 0;
  for (const Sensor& sensor : sensors) sum += sensor.taken;
  turn.hand_over();
  stop.store(true, std::memory_order_relaxed);
  bell.ring();
  EXPECT_EQ(sum, kThreads * kFrames);
}

}  // namespace
}  // namespace slipd
