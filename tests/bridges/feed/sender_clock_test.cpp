#include "bridges/feed_lane/sender_clock.hpp"

#include <gtest/gtest.h>

namespace slipd::feed {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kZeroNs = 1'700'000'000'000'000'000;  // of the sender's clock, before this computer's

TEST(SenderClock, TimesMessagesByTheSendersClockWhateverItsZero) {
  SenderClock clock;
  for (std::int64_t i = 1; i < 100; ++i) {
    const std::int64_t sent = i * 10 * kMs, under_way = i % 7 * kMs;
    const std::int64_t when = clock.when(kZeroNs + sent, sent + under_way);
    if (i >= 7) {
      EXPECT_EQ(when, sent) << i;
    }
    EXPECT_LE(when, sent + under_way);
  }
}

TEST(SenderClock, GivesABurstAfterAStandstillItsAge) {
  SenderClock clock;
  for (std::int64_t ms = 1; ms < 1000; ms += 10) clock.when(kZeroNs + ms * kMs, ms * kMs);
  for (std::int64_t ms = 1001; ms < 1500; ms += 10)
    EXPECT_EQ(clock.when(kZeroNs + ms * kMs, 1500 * kMs + ms), ms * kMs);
}

TEST(SenderClock, FollowsAClockThatRunsFasterOrSlower) {
  for (const double rate : {1 - 1e-4, 1 + 1e-4}) {
    SenderClock clock;
    std::int64_t last = 0;
    for (std::int64_t ms = 1; ms < 60'000; ms += 10) {
      const std::int64_t when =
          clock.when(static_cast<std::int64_t>(rate * static_cast<double>(ms * kMs)), ms * kMs);
      // The clocks run apart for at most two windows, each a message longer.
      EXPECT_LE(ms * kMs - when, 2 * (SenderClock::kWindowNs + 10 * kMs) / 10'000 + 1);
      EXPECT_LE(when, ms * kMs);
      EXPECT_GT(when, last);
      last = when;
    }
  }
}

TEST(SenderClock, IsNeverEarlyAndRisesForAnyTimesOfTheSender) {
  SenderClock clock;
  std::int64_t last = 0;
  for (std::int64_t ms = 1; ms < 2000; ++ms) {
    const std::int64_t sent = (ms * 7919 % 1000 - 500) * 1000 * kMs;
    const std::int64_t when = clock.when(sent, ms * kMs);
    EXPECT_LE(when, ms * kMs);
    EXPECT_GT(when, last);
    last = when;
  }
}

TEST(SenderClock, HearsASenderWhoseClockWasSetBackAgainWithinTwoWindows) {
  SenderClock clock;
  for (std::int64_t ms = 1; ms < 1000; ms += 10) clock.when(kZeroNs + ms * kMs, ms * kMs);
  std::int64_t age = 0;
  for (std::int64_t ms = 1000; ms < 12'000; ms += 10) age = ms * kMs - clock.when(ms * kMs, ms * kMs);
  EXPECT_EQ(age, 0);
}

TEST(SenderClock, TimesMessagesAcrossTheWrapOfTheSendersClock) {
  constexpr std::int64_t kRangeNs = (std::int64_t{1} << 32) * 1000;  // 32 bit of us: 71.6 min
  SenderClock clock;
  for (std::int64_t ms = 1; ms < 10'000; ms += 10) {
    const std::int64_t sent = (kRangeNs - 5000 * kMs + ms * kMs) % kRangeNs, under_way = ms / 10 % 7 * kMs;
    const std::int64_t when = clock.when(sent, ms * kMs + under_way, kRangeNs);
    EXPECT_EQ(when, ms * kMs) << ms;
  }
}

TEST(SenderClock, TimesMessagesAfterAPauseOfManyWraps) {
  constexpr std::int64_t kRangeNs = 65'536'000;  // 16 bit of us
  SenderClock clock;
  for (const std::int64_t ms : {1, 11, 21, 500, 510, 4000, 4010})
    EXPECT_EQ(clock.when(ms * kMs % kRangeNs, ms * kMs, kRangeNs), ms * kMs) << ms;
  EXPECT_EQ(clock.when(4020 * kMs % kRangeNs, 4040 * kMs, kRangeNs), 4020 * kMs) << "20 ms under way";
}

}  // namespace
}  // namespace slipd::feed
