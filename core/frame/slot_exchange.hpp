// Which of three slots belongs to whom: one thread fills, one reads, the third slot lies in the middle, and
// each side trades its own for that one by a single exchange. Apart from what is in the slots, so that a test
// can run it, as it is, through every order of events that the memory model allows.
#pragma once

#include <atomic>
#include <cstdint>

namespace slipd {

template <template <typename> class Atomic = std::atomic>
class SlotExchange {
 public:
  // Filling thread: its slot, 0 to 2.
  std::uint32_t filling() const noexcept { return filling_; }

  // Filling thread: hands its slot over and gets another. True if nobody had looked at what was handed over
  // before.
  bool hand_over() noexcept {
    // Release: pairs with the acquire in take(), which sees the slot's contents. Acquire: pairs with the
    // release in take(), so that its reads of the slot that we get back are over before we write there.
    const std::uint32_t was = middle_.exchange(filling_ | kFresh, std::memory_order_acq_rel);
    filling_ = was & kIndex;
    return (was & kFresh) != 0;
  }

  // Either thread: whether what was handed over has not been taken yet. Relaxed: a hint, nothing is read on
  // its word.
  bool fresh() const noexcept { return (middle_.load(std::memory_order_relaxed) & kFresh) != 0; }

  // FrameEstimate thread: true if there was something new, which is now in reading().
  bool take() noexcept {
    if (!fresh()) return false;
    // Acquire and release: the mirror image of hand_over(), with which each of them pairs. Only this thread
    // clears kFresh, so it is still set.
    reading_ = middle_.exchange(reading_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  // FrameEstimate thread: its slot.
  std::uint32_t reading() const noexcept { return reading_; }

 private:
  static constexpr std::uint32_t kIndex = 3;
  static constexpr std::uint32_t kFresh = 4;
  alignas(64) std::uint32_t filling_ = 0;
  alignas(64) std::uint32_t reading_ = 1;
  alignas(64) Atomic<std::uint32_t> middle_{2};
};

}  // namespace slipd
