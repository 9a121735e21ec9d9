// Where the acquire thread leaves a sensor's newest frame for the estimate thread: three slots and one atomic
// word.
//
// The acquire thread owns one slot, the estimate thread another, the third lies in the middle. Each side
// trades its own for the one in the middle by a single exchange, so both are wait-free, the newest frame
// always wins however long the estimator was away, and a frame is skipped exactly when an unread one comes
// back out of the middle. A deeper queue would hand over older frames first, cost more memory, and need a way
// to drop from its far end.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/slot_exchange.hpp"

namespace slipd {

// What the acquire thread had counted when it published a frame. It travels with the frame, so that the
// estimate thread's sums belong together: what it takes as number n after number m means that n - m - 1 were
// skipped.
struct Tally {
  std::uint64_t received = 0;  // frames so far, this one included
  std::uint64_t gaps = 0;      // jumps of the sequence number
  std::uint64_t lost = 0;      // sequence numbers that those jumps left out
};

class FrameMailbox {
 public:
  // All memory there ever is: three slots of 3 x taxels floats, touched here so that no page fault comes
  // later.
  explicit FrameMailbox(std::size_t taxels);
  FrameMailbox(const FrameMailbox&) = delete;
  FrameMailbox& operator=(const FrameMailbox&) = delete;

  // Acquire thread: the slot to fill next. Valid until publish.
  FrameSlot writable() const noexcept { return entries_[exchange_.filling()].slot; }

  // Acquire thread: hands over `filled`, which writable() gave and the driver filled. True if an unread frame
  // was replaced by it (which is then counted as skipped).
  bool publish(const FrameSlot& filled, const Tally& tally = {}) noexcept {
    entries_[exchange_.filling()].slot = filled;
    entries_[exchange_.filling()].tally = tally;
    return exchange_.hand_over();
  }

  // Either thread: whether a published frame has not been taken yet. A hint.
  bool unread() const noexcept { return exchange_.fresh(); }

  // Estimate thread: the newest frame not yet seen, or null. Valid until the next take.
  const FrameSlot* take() noexcept {
    return exchange_.take() ? &entries_[exchange_.reading()].slot : nullptr;
  }

  // Estimate thread: what was published with the frame last taken.
  const Tally& tally() const noexcept { return entries_[exchange_.reading()].tally; }

 private:
  // A cache line is never both sides' at once: what one writes for itself would slow the other one down. Each
  // entry is one side's while it is held, so it has its lines for itself, as the exchange's words have.
  static constexpr std::size_t kLine = 64;
  struct alignas(kLine) Entry {
    FrameSlot slot;
    Tally tally;
  };
  static_assert(sizeof(Entry) % kLine == 0);
  std::vector<float> memory_;
  std::array<Entry, 3> entries_;
  SlotExchange<> exchange_;
};

}  // namespace slipd
