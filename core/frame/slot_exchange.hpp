// A triple buffer's index logic: which of three slots the writer owns, which the reader owns, and which is in
// between. Each side exchanges its own slot for the middle one by one atomic operation. It is separate from
// the slots' contents, so that a test can run it through every order that the memory model allows.
//
// One interleaving, time running down. "2!" is slot 2 marked unread.
//
//   writer (acquire)          middle   reader (estimate)     result of the exchange
//   owns 0                      2      owns 1
//   fills 0
//   publish: exchange ------->  0!     .                     writer gets 2, read: publish is false
//   fills 2                     0!     .
//   publish: exchange ------->  2!     .                     writer gets 0!, unread: publish is true
//   fills 0                     1  <-- take: exchange        reader gets 2, the newest
//   publish: exchange ------->  0!     reads 2               writer gets 1, read: publish is false
//   fills 1                     2  <-- take: exchange        reader gets 0
//
// The two sides never own the same slot, because every slot index is in exactly one of three places.
#pragma once

#include <atomic>
#include <cstdint>

namespace slipd {

// Thread-safe between one writer and one reader. `Atomic` is std::atomic except in the memory-model test.
template <template <typename> class Atomic = std::atomic>
class SlotExchange {
 public:
  // Called from one thread: the writer. The slot that it owns, 0 to 2.
  std::uint32_t writer_slot() const noexcept { return writer_slot_; }

  // Called from one thread: the writer. Publishes its slot and gets another. Returns true if the slot
  // published before was not taken. Wait-free.
  bool publish() noexcept {
    // Release: pairs with the acquire in take(), so that the reader sees the slot's contents. Acquire: pairs
    // with the release in take(), so that the reader's accesses to the slot we get end before our writes.
    const std::uint32_t was = middle_.exchange(writer_slot_ | kUnread, std::memory_order_acq_rel);
    writer_slot_ = was & kIndex;
    return (was & kUnread) != 0;
  }

  // Called from both threads. Whether a published slot was not taken yet. A hint.
  bool has_unread() const noexcept {
    // Relaxed: no other memory is read because of this value.
    return (middle_.load(std::memory_order_relaxed) & kUnread) != 0;
  }

  // Called from one thread: the reader. Returns true if there was an unread slot, which is now reader_slot().
  // Wait-free.
  bool take() noexcept {
    if (!has_unread()) return false;
    // Acquire pairs with the release in publish(), release with its acquire. Only the reader clears kUnread,
    // so it is still set here.
    reader_slot_ = middle_.exchange(reader_slot_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  // Called from one thread: the reader. The slot that it owns, 0 to 2.
  std::uint32_t reader_slot() const noexcept { return reader_slot_; }

 private:
  static constexpr std::uint32_t kIndex = 3;
  static constexpr std::uint32_t kUnread = 4;
  // A cache line each, against false sharing.
  alignas(64) std::uint32_t writer_slot_ = 0;
  alignas(64) std::uint32_t reader_slot_ = 1;
  alignas(64) Atomic<std::uint32_t> middle_{2};
};

}  // namespace slipd
