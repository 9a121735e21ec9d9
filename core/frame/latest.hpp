// The latest value of something, from one real-time writer to any number of readers: two seqlocks, written in
// turn. The writer never waits, and a reader never waits for a writer that was preempted.
//
// The writer fills the copy that current_ does not point to, then points current_ to it. A reader copies what
// current_ points to and verifies that no write to this copy began meanwhile. It retries only if a whole
// store ended while it read.
//
// One interleaving, time running down. Copy 0 holds A at version 2, current_ = 0.
//
//   writer: store(B)                      reader: load()
//   copy 1: version 3 (odd: writing)
//                                         current_ -> 0, version -> 2
//   copy 1: words of B                    reads words of A
//   copy 1: version 4
//   current_ = 1
//                                         version of copy 0 -> 2, unchanged
//                                         current_ -> 1, not 0: retry
//                                         current_ -> 1, version -> 4, words of B, version -> 4
//   (store(C) would fill copy 0)          current_ -> 1: returns B
//
// The second look at current_ makes the order of values monotonic: no reader sees B and later A.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace slipd {

// Thread-safe between one writer and any number of readers. `Atomic` is std::atomic except in the
// memory-model test.
template <typename T, template <typename> class Atomic = std::atomic>
class Latest {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % sizeof(std::uint64_t) == 0);

 public:
  // Called from one thread, before any other uses it.
  explicit Latest(const T& initial = T{}) noexcept { store(initial); }
  Latest(const Latest&) = delete;
  Latest& operator=(const Latest&) = delete;

  // Called from one thread: the writer. Wait-free.
  void store(const T& value) noexcept {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    // Relaxed: only the writer changes current_ and the versions.
    const std::uint32_t next = 1 - current_.load(std::memory_order_relaxed);
    Copy& copy = copies_[next];
    const std::uint64_t version = copy.version.load(std::memory_order_relaxed);
    copy.version.store(version + 1, std::memory_order_relaxed);
    // Release on each word: a reader that sees one of them also sees the odd version above and discards its
    // copy. (Relaxed words after a fence would be correct too, but ThreadSanitizer does not model fences.)
    for (std::size_t i = 0; i < kWords; ++i) copy.words[i].store(words[i], std::memory_order_release);
    copy.version.store(version + 2, std::memory_order_release);  // pairs with the acquire of `before` in load
    current_.store(next, std::memory_order_release);             // pairs with the acquire of current_ in load
  }

  // Called from any thread. Lock-free: repeats only if a store ended meanwhile.
  T load() const noexcept {
    // The words go to their places at once: a second copy of them would wait for the stores of the first.
    T value;
    auto* const bytes = reinterpret_cast<std::byte*>(&value);
    for (;;) {
      const std::uint32_t index = current_.load(std::memory_order_acquire);
      const Copy& copy = copies_[index];
      const std::uint64_t before = copy.version.load(std::memory_order_acquire);
      // Acquire on each word: keeps the load of `after` behind it, and pairs with the release in store.
      for (std::size_t i = 0; i < kWords; ++i) {
        const std::uint64_t word = copy.words[i].load(std::memory_order_acquire);
        std::memcpy(bytes + sizeof word * i, &word, sizeof word);
      }
      const std::uint64_t after = copy.version.load(std::memory_order_relaxed);
      // A reader that was preempted may find this copy filled anew but not yet published. It has then seen
      // the new words, and with them that current_ points to the other copy.
      // Relaxed, as `after` is: the acquire of the words keeps both loads behind them.
      const bool published = current_.load(std::memory_order_relaxed) == index;
      if (before == after && (before & 1) == 0 && published) return value;
    }
  }

 private:
  static constexpr std::size_t kWords = sizeof(T) / sizeof(std::uint64_t);
  struct alignas(64) Copy {
    Atomic<std::uint64_t> version{0};
    std::array<Atomic<std::uint64_t>, kWords> words{};
  };
  std::array<Copy, 2> copies_;
  alignas(64) Atomic<std::uint32_t> current_{0};
};

}  // namespace slipd
