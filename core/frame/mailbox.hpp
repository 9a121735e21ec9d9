// Hands a sensor's newest frame from the acquire thread to the estimate thread: three slots, exchanged by
// SlotExchange.
//
// Both sides are wait-free. The newest frame wins, however late the estimate thread is. A frame counts as
// skipped exactly when publish replaces one that was not taken. A queue would hand over the oldest frame
// first, need more memory, and drop the newest frame when full.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/slot_exchange.hpp"

namespace slipd {

// The acquire thread's counters at the time it published a frame. They travel with the frame. A reader that
// takes a frame with received = n after one with received = m knows that n - m - 1 frames were skipped.
struct ArrivalCounts {
  std::uint64_t received = 0;  // frames up to and with this one
  std::uint64_t gaps = 0;      // jumps of the sequence number so far
  std::uint64_t lost = 0;      // sequence numbers missing in those jumps
};

// Thread-safe between one writer and one reader. Constructed and destroyed while neither runs.
class FrameMailbox {
 public:
  // Allocates all memory: three slots of 3 x `taxels` floats. Writes to it, so that no page fault comes
  // later.
  explicit FrameMailbox(std::size_t taxels);
  FrameMailbox(const FrameMailbox&) = delete;
  FrameMailbox& operator=(const FrameMailbox&) = delete;

  // Called from one thread: acquire. The slot to fill next; valid until publish.
  FrameSlot writable() const noexcept { return entries_[exchange_.writer_slot()].slot; }

  // Called from one thread: acquire. Publishes `filled`, which is a copy of writable() with its values set.
  // Returns true if it replaced a frame that was not taken. Wait-free.
  bool publish(const FrameSlot& filled, const ArrivalCounts& arrivals = {}) noexcept {
    entries_[exchange_.writer_slot()].slot = filled;
    entries_[exchange_.writer_slot()].arrivals = arrivals;
    return exchange_.publish();
  }

  // Called from both threads. Whether a published frame was not taken yet. Only a hint: the answer may be
  // outdated when it returns.
  bool has_unread() const noexcept { return exchange_.has_unread(); }

  // Called from one thread: estimate. The newest frame if it was not taken before, else null. Valid until the
  // next take that returns a frame. Wait-free.
  const FrameSlot* take() noexcept {
    return exchange_.take() ? &entries_[exchange_.reader_slot()].slot : nullptr;
  }

  // Called from one thread: estimate. The counters published with the frame last taken; zeros before the
  // first.
  const ArrivalCounts& arrivals() const noexcept { return entries_[exchange_.reader_slot()].arrivals; }

 private:
  // Each entry has cache lines of its own: at any time it belongs to one side, and a shared line would slow
  // the other side down (false sharing).
  static constexpr std::size_t kLine = 64;
  struct alignas(kLine) Entry {
    FrameSlot slot;
    ArrivalCounts arrivals;
  };
  static_assert(sizeof(Entry) % kLine == 0);
  std::vector<float> memory_;
  std::array<Entry, 3> entries_;
  SlotExchange<> exchange_;
};

}  // namespace slipd
