// Data shared by threads, accessed from several threads at once.
#include "daemon/board/board.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <array>
#include <thread>

#include "core/frame/latest.hpp"
#include "daemon/board/frame_copy.hpp"
#include "daemon/board/latency.hpp"
#include "daemon/board/record_tap.hpp"
#include "daemon/rt/io_wakeup.hpp"
#include "tests/support/patience.hpp"

namespace slipd {
namespace {

// an odd number, so that no boundary of alignment coincides with the end
using Words = std::array<std::uint64_t, 37>;

Words all(std::uint64_t value) {
  Words words{};
  words.fill(value);
  return words;
}

TEST(Latest, IsItsFirstValueUntilAnotherIsStored) {
  Latest<Words> latest(all(7));
  EXPECT_EQ(latest.load(), all(7));
  latest.store(all(8));
  EXPECT_EQ(latest.load(), all(8));
}

TEST(Latest, IsNeverTornAndNeverGoesBack) {
  Latest<Words> latest(all(0));
  constexpr std::uint64_t kStores = 200000;
  const auto read = [&] {
    std::uint64_t last = 0;
    while (last < kStores) {
      const Words words = latest.load();
      ASSERT_EQ(words, all(words[0]));
      ASSERT_GE(words[0], last);
      last = words[0];
    }
  };
  std::thread first(read);
  std::thread second(read);
  for (std::uint64_t i = 1; i <= kStores; ++i) latest.store(all(i));
  first.join();
  second.join();
}

TEST(IoWakeup, IsSeenHoweverNotifyAndClearMeet) {
  IoWakeup wake;
  std::atomic<int> published{0};
  constexpr int kRings = 20000;
  std::thread publisher([&] {
    for (int i = 1; i <= kRings; ++i) {
      published.store(i);
      wake.notify();
    }
  });
  int seen = 0;
  while (seen < kRings) {
    pollfd ready{wake.fd(), POLLIN, 0};
    ASSERT_EQ(poll(&ready, 1, testing::kPollPatience), 1) << "no wake-up for value " << published.load();
    wake.clear();
    seen = published.load();
  }
  publisher.join();
}

TEST(LatencyHistogram, QuantilesAreWithinABucketAndTheMaximumExact) {
  LatencyHistogram histogram;
  EXPECT_EQ(histogram.summary().count, 0U);
  EXPECT_EQ(histogram.summary().p50_us, 0);
  for (int i = 1; i <= 1000; ++i) histogram.record(i * 1000);
  const auto summary = histogram.summary();
  EXPECT_EQ(summary.count, 1000U);
  // Eight buckets for each factor of 2: at most an eighth too high, never too low.
  EXPECT_GE(summary.p50_us, 500);
  EXPECT_LE(summary.p50_us, 500 * 1.13);
  EXPECT_GE(summary.p99_us, 990);
  EXPECT_LE(summary.p999_us, summary.max_us);
  EXPECT_EQ(summary.max_us, 1000);
}

TEST(LatencyHistogram, TakesEveryTimeThereCanBe) {
  LatencyHistogram histogram;
  for (const std::int64_t time :
       {std::int64_t{-5}, std::int64_t{0}, std::int64_t{7}, std::int64_t{8}, INT64_MAX}) {
    histogram.record(time);
  }
  EXPECT_EQ(histogram.summary().count, 5U);
  EXPECT_DOUBLE_EQ(histogram.summary().max_us, static_cast<double>(INT64_MAX) * 1e-3);
}

struct OwnSlot {
  explicit OwnSlot(std::size_t taxels, float value = 1) : memory(3 * taxels, value) {
    const std::span<float> all_of_it(memory);
    slot.normal_pa = all_of_it.subspan(0, taxels);
    slot.shear_x_pa = all_of_it.subspan(taxels, taxels);
    slot.shear_y_pa = all_of_it.subspan(2 * taxels, taxels);
  }
  std::vector<float> memory;
  FrameSlot slot;
};

TEST(FrameCopy, IsMadeOnlyWhenAskedFor) {
  FrameCopy copy;
  const OwnSlot own(4);
  EXPECT_FALSE(copy.fill_if_requested(&own.slot));
  EXPECT_EQ(copy.result(), nullptr);
  copy.request(4);
  EXPECT_TRUE(copy.fill_if_requested(&own.slot));
  ASSERT_NE(copy.result(), nullptr);
  EXPECT_EQ(copy.result()->normal_pa, std::vector<float>(4, 1.0F));
  copy.release();
  EXPECT_FALSE(copy.fill_if_requested(&own.slot));
}

TEST(FrameCopy, SaysWhenThereIsNoFrameOrOneThatDoesNotFit) {
  FrameCopy copy;
  copy.request(4);
  EXPECT_TRUE(copy.fill_if_requested(nullptr));
  EXPECT_FALSE(copy.result()->has_frame);
  copy.release();
  copy.request(4);
  const OwnSlot other(5);
  EXPECT_TRUE(copy.fill_if_requested(&other.slot));
  EXPECT_FALSE(copy.result()->has_frame);
}

TEST(RecordTap, EveryFrameOfferedIsTakenOrCountedAsMissed) {
  RecordTap tap;
  constexpr std::uint64_t kFrames = 50000;
  std::atomic<bool> over{false};
  std::thread acquire([&] {
    OwnSlot own(4);
    for (std::uint64_t i = 0; i < kFrames; ++i) {
      own.slot.sequence = i;
      std::fill(own.memory.begin(), own.memory.end(), static_cast<float>(i));
      tap.offer(own.slot);
    }
    over = true;
  });
  // Recordings begin and end while frames are offered; a queue may be destroyed as soon as it is detached.
  while (!over) {
    FrameQueue queue(4, 8);
    ASSERT_TRUE(tap.attach(queue));
    FrameQueue second(4, 8);
    ASSERT_FALSE(tap.attach(second)) << "one recording at a time";
    std::uint64_t taken = 0;
    std::uint64_t first = 0;
    std::uint64_t last = 0;
    const auto take_all = [&] {
      while (const FrameSlot* frame = queue.front()) {
        if (taken == 0) first = frame->sequence;
        ASSERT_TRUE(taken == 0 || frame->sequence > last);
        last = frame->sequence;
        ASSERT_EQ(frame->shear_y_pa[3], static_cast<float>(last));
        queue.pop();
        ++taken;
      }
    };
    for (int i = 0; i < 200; ++i) take_all();
    tap.detach();
    take_all();
    if (taken > 0) {
      ASSERT_GE(taken + queue.missed(), last - first + 1);
    }
  }
  acquire.join();
}

TEST(DriverWatch, TellsThatADriverHangsOnceItsCallShouldHaveReturned) {
  SensorStatus status("left", "trial");
  const auto trouble_at = [&](std::int64_t now_ns) { return device_trouble(status, status.facts(), now_ns); };
  status.change_facts([](DeviceFacts& facts) { facts.trouble = "the device is gone"; });
  EXPECT_EQ(trouble_at(5000), "the device is gone");
  status.driver_watch.enter(DriverWatch::Call::open, 1000);
  EXPECT_EQ(trouble_at(1000), "the device is gone") << "it may still return";
  EXPECT_EQ(trouble_at(1001).find("its driver does not return from open"), 0U);
  status.driver_watch.enter(DriverWatch::Call::read, 2000);
  EXPECT_EQ(trouble_at(2000), "the device is gone");
  EXPECT_EQ(trouble_at(2001).find("its driver does not return from read"), 0U);
  status.driver_watch.leave();
  EXPECT_EQ(trouble_at(5000), "the device is gone");
}

}  // namespace
}  // namespace slipd
