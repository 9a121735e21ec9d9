// The doorbell between threads: no ring is missed, and every wait ends.
#include "daemon/rt/doorbell.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "tests/support/patience.hpp"

namespace slipd {
namespace {

using namespace std::chrono_literals;
using Clock = Doorbell::Clock;

TEST(Doorbell, AWaitEndsAtItsTime) {
  Doorbell bell;
  const auto until = Clock::now() + 20ms;
  while (bell.wait(bell.ring_count(), until)) {
  }
  EXPECT_GE(Clock::now(), until);
}

TEST(Doorbell, ARingBeforeTheWaitEndsItAtOnce) {
  Doorbell bell;
  const auto seen = bell.ring_count();
  bell.ring();
  EXPECT_TRUE(bell.wait(seen, Clock::now() + 1h));
}

TEST(Doorbell, EveryRingEndsAWait) {
  Doorbell there;
  Doorbell back;
  std::atomic<int> ball{0};
  constexpr int kThrows = 20000;
  const auto play = [&](Doorbell& mine, Doorbell& theirs, int parity) {
    for (;;) {
      const auto seen = mine.ring_count();
      const int now = ball.load();
      if (now >= kThrows) break;
      if (now % 2 == parity) {
        ball.store(now + 1);
        theirs.ring();
      } else {
        ASSERT_TRUE(mine.wait(seen, Clock::now() + testing::kPatience))
            << "throw " << now << " was not heard";
      }
    }
    theirs.ring();
  };
  std::thread other([&] { play(back, there, 1); });
  play(there, back, 0);
  other.join();
  EXPECT_EQ(ball.load(), kThrows);
}

}  // namespace
}  // namespace slipd
