#include "core/frame/mailbox.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

namespace slipd {
namespace {

void send(FrameMailbox& mailbox, std::uint64_t sequence, std::uint64_t& skipped) {
  auto slot = mailbox.writable();
  slot.sequence = sequence;
  std::fill(slot.normal_pa.begin(), slot.normal_pa.end(), static_cast<float>(sequence));
  std::fill(slot.shear_y_pa.begin(), slot.shear_y_pa.end(), static_cast<float>(sequence));
  skipped += mailbox.publish(slot) ? 1 : 0;
}

TEST(FrameMailbox, IsEmptyUntilAFrameComesAndGivesItOnce) {
  FrameMailbox mailbox(4);
  std::uint64_t skipped = 0;
  EXPECT_EQ(mailbox.take(), nullptr);
  send(mailbox, 7, skipped);
  ASSERT_NE(mailbox.take(), nullptr);
  EXPECT_EQ(mailbox.take(), nullptr);
  EXPECT_EQ(skipped, 0U);
}

TEST(FrameMailbox, GivesTheNewestFrameAfterAnyDelay) {
  FrameMailbox mailbox(4);
  std::uint64_t skipped = 0;
  for (std::uint64_t i = 1; i <= 1000; ++i) send(mailbox, i, skipped);
  EXPECT_EQ(mailbox.take()->sequence, 1000U);
  EXPECT_EQ(skipped, 999U);
}

TEST(FrameMailbox, AFrameThatIsReadDoesNotChangeWhileOthersCome) {
  FrameMailbox mailbox(4);
  std::uint64_t skipped = 0;
  send(mailbox, 1, skipped);
  const FrameSlot* held = mailbox.take();
  for (std::uint64_t i = 2; i <= 10; ++i) send(mailbox, i, skipped);
  EXPECT_EQ(held->sequence, 1U);
  EXPECT_EQ(held->normal_pa[3], 1.0F);
}

TEST(FrameMailbox, AcrossThreadsFramesStayWholeInOrderAndAllAreAccountedFor) {
  constexpr std::uint64_t kFrames = 200000;
  FrameMailbox mailbox(16);
  std::uint64_t skipped = 0, taken = 0, last = 0;
  std::thread producer([&] {
    for (std::uint64_t i = 1; i <= kFrames; ++i) send(mailbox, i, skipped);
  });
  while (last < kFrames) {
    const FrameSlot* slot = mailbox.take();
    if (slot == nullptr) continue;
    ++taken;
    ASSERT_GT(slot->sequence, last);
    last = slot->sequence;
    const auto whole = [&](float v) { return v == static_cast<float>(slot->sequence); };
    ASSERT_TRUE(std::all_of(slot->normal_pa.begin(), slot->normal_pa.end(), whole));
    ASSERT_TRUE(std::all_of(slot->shear_y_pa.begin(), slot->shear_y_pa.end(), whole));
  }
  producer.join();
  EXPECT_EQ(taken + skipped, kFrames);
}

}  // namespace
}  // namespace slipd
