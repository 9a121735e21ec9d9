// The exchange of slots between two threads, in every order of events that release and acquire allow.
#include "core/frame/slot_exchange.hpp"

#include <gtest/gtest.h>

#include <array>

#include "tests/support/memory_model/weak_memory.hpp"

namespace slipd {
namespace {

using testing::CheckedAtomic;
using testing::demand;
using testing::Violation;
using testing::WeakMemory;
using Access = WeakMemory::Access;

constexpr std::size_t kFiller = 1, kReader = 2;
constexpr int kFrames = 5, kLooks = 4;

// An Atomic for the exchange, which lets the filler do any part of its remaining work before each of the
// reader's accesses. publish() accesses shared memory once, so this covers all orders.
template <typename T>
class Interleaved : public CheckedAtomic<T> {
 public:
  using CheckedAtomic<T>::CheckedAtomic;
  static inline std::function<void()> meanwhile = [] {};
  T load(std::memory_order order) const {
    meanwhile();
    return CheckedAtomic<T>::load(order);
  }
  T exchange(T value, std::memory_order order) {
    meanwhile();
    return CheckedAtomic<T>::exchange(value, order);
  }
};

// Frames 1 to kFrames through a mailbox, read at any moments; each path must keep the mailbox's guarantees.
void pass_frames(WeakMemory& memory) {
  SlotExchange<Interleaved> slots;
  std::array<int, 3> content{};
  std::array<std::size_t, 3> place{};
  for (auto& each : place) each = memory.add_plain();
  memory.synchronize(0, kFiller);
  memory.synchronize(0, kReader);
  int filled = 0, skipped = 0, taken = 0, last = 0;
  bool filling = false;

  const auto fill_some = [&] {
    if (filling) return;  // an access of the filler itself
    filling = true;
    memory.run_as(kFiller);
    for (std::size_t more = memory.choose(static_cast<std::size_t>(kFrames - filled) + 1); more > 0; --more) {
      memory.write_plain(place[slots.writer_slot()]);
      content[slots.writer_slot()] = ++filled;
      skipped += slots.publish() ? 1 : 0;
    }
    memory.run_as(kReader);
    filling = false;
  };
  const auto look = [&] {
    if (!slots.take()) return false;
    memory.read_plain(place[slots.reader_slot()]);
    const int frame = content[slots.reader_slot()];
    demand(frame > last, "a frame came twice, or an older one after it");
    last = frame;
    ++taken;
    return true;
  };

  Interleaved<std::uint32_t>::meanwhile = fill_some;
  memory.run_as(kReader);
  for (int i = 0; i < kLooks; ++i) {
    const int before = filled;
    if (memory.choose(2) == 1) {  // the doorbell has rung for all frames so far
      memory.synchronize(kFiller, kReader);
      demand(look() || last == before, "a frame was announced and not there");
      demand(last >= before, "an old frame came though a newer one was announced");
    } else {
      look();
    }
  }
  Interleaved<std::uint32_t>::meanwhile = [] {};
  memory.synchronize(kFiller, kReader);
  look();
  demand(last == filled, "the newest frame did not win");
  demand(taken + skipped == filled, "the account does not close");
}

TEST(SlotExchange, InEveryOrderOfEventsFramesComeWholeInOrderAndAllAreAccountedFor) {
  const std::size_t paths = WeakMemory::explore(pass_frames);
  RecordProperty("paths", static_cast<int>(paths));
  EXPECT_GT(paths, 1000U);
}

TEST(SlotExchange, NeedsEachOfItsOrders) {
  for (const std::size_t thread : {kFiller, kReader}) {
    for (const std::memory_order half : {std::memory_order_acquire, std::memory_order_release}) {
      const auto weakened = [&](std::size_t, std::size_t by, Access access, std::memory_order order) {
        return by == thread && access == Access::exchange ? half : order;
      };
      EXPECT_THROW(WeakMemory::explore(pass_frames, weakened), Violation)
          << "thread " << thread
          << (half == std::memory_order_acquire ? " without release" : " without acquire");
    }
  }
}

}  // namespace
}  // namespace slipd
