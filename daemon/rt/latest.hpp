// The newest value of something, from one real-time writer to any number of readers: two seqlocks, used in
// turn.
//
// The writer always fills the copy that readers are not sent to, so it never waits, and a reader never waits
// for a writer that was preempted half-way; it only looks again if a whole write ended while it copied. What
// it took is published by then: nobody sees a value, and then the one before it.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace slipd {

// `Atomic`: std::atomic, but for the test that tries every order of events that the memory model allows.
template <typename T, template <typename> class Atomic = std::atomic>
class Latest {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit Latest(const T& initial = T{}) noexcept { store(initial); }
  Latest(const Latest&) = delete;
  Latest& operator=(const Latest&) = delete;

  // The one writer's thread. Wait-free.
  void store(const T& value) noexcept {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    // Relaxed: only this thread writes current_ and the versions.
    const std::uint32_t next = 1 - current_.load(std::memory_order_relaxed);
    Copy& copy = copies_[next];
    const std::uint64_t version = copy.version.load(std::memory_order_relaxed);
    copy.version.store(version + 1, std::memory_order_relaxed);
    // Release, each word: whoever reads one of them also sees the odd version above, and so throws its copy
    // away. (Relaxed words behind a fence would do too, but ThreadSanitizer knows no fences.)
    for (std::size_t i = 0; i < kWords; ++i) copy.words[i].store(words[i], std::memory_order_release);
    copy.version.store(version + 2, std::memory_order_release);  // pairs with the acquire of `before` in load
    current_.store(next, std::memory_order_release);             // pairs with the acquire of current_ in load
  }

  // Any thread.
  T load() const noexcept {
    std::array<std::uint64_t, kWords> words{};
    for (;;) {
      const std::uint32_t index = current_.load(std::memory_order_acquire);
      const Copy& copy = copies_[index];
      const std::uint64_t before = copy.version.load(std::memory_order_acquire);
      // Acquire, each word: keeps the load of `after` behind it, and pairs with the release in store.
      for (std::size_t i = 0; i < kWords; ++i) words[i] = copy.words[i].load(std::memory_order_acquire);
      const std::uint64_t after = copy.version.load(std::memory_order_relaxed);
      // A reader that was away may find a copy filled anew but not yet pointed at. Having seen its words it
      // also sees that current_ points to the other copy: equal here means that these words are the published
      // ones.
      // Relaxed, as `after` is: the acquire of the words is what keeps both behind.
      const bool published = current_.load(std::memory_order_relaxed) == index;
      if (before == after && (before & 1) == 0 && published) break;
    }
    T value;
    std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
    return value;
  }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;
  struct alignas(64) Copy {
    Atomic<std::uint64_t> version{0};
    std::array<Atomic<std::uint64_t>, kWords> words{};
  };
  std::array<Copy, 2> copies_;
  alignas(64) Atomic<std::uint32_t> current_{0};
};

}  // namespace slipd
