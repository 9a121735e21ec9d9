// A counter-based random number generator. Each number is a hash of its index, not of the numbers drawn
// before, so that any block of a data set can be made again alone, on any thread and any machine. The hash is
// the finaliser of splitmix64 (docs/methods.md §35). Distributions of the standard library differ between
// implementations and are not used.
#pragma once

#include <cstdint>

namespace slipd {

// A sequence of random numbers. Immutable: called from any thread.
class RandomStream {
 public:
  constexpr explicit RandomStream(std::uint64_t seed) noexcept : key_(mix(seed + kStep)) {}

  // Another sequence, independent of this one and of those of other indices.
  constexpr RandomStream stream(std::uint64_t index) const noexcept {
    RandomStream child(key_);
    child.key_ = mix(child.key_ ^ mix((index + 1) * kStep));
    return child;
  }

  // The number at index i, 64 bits.
  constexpr std::uint64_t bits(std::uint64_t i) const noexcept { return mix(key_ + (i + 1) * kStep); }

  // The number at index i, uniform in [0, 1), 53 bits.
  constexpr double uniform(std::uint64_t i) const noexcept {
    return static_cast<double>(bits(i) >> 11) * 0x1p-53;
  }

  // The number at index i, uniform from low to high.
  constexpr double uniform(std::uint64_t i, double low, double high) const noexcept {
    return low + (high - low) * uniform(i);
  }

  // The number at index i, uniform in [-1, 1), 24 bits. Two neighbouring ones share one hash.
  constexpr float noise(std::uint64_t i) const noexcept { return half(bits(i / 2), i % 2 != 0); }

  // Adds half_width * noise(i) to values[i], for i from 0 to n - 1.
  void add_noise(float* values, std::uint64_t n, float half_width) const noexcept {
    for (std::uint64_t i = 0; i + 1 < n; i += 2) {
      const std::uint64_t both = bits(i / 2);
      values[i] += half_width * half(both, false);
      values[i + 1] += half_width * half(both, true);
    }
    if (n % 2 != 0) values[n - 1] += half_width * noise(n - 1);
  }

 private:
  static constexpr std::uint64_t kStep = 0x9E3779B97F4A7C15ULL;

  static constexpr float half(std::uint64_t both, bool upper) noexcept {
    const auto word = static_cast<std::int32_t>(static_cast<std::uint32_t>(upper ? both >> 32 : both));
    return static_cast<float>(word >> 8) * 0x1p-23F;
  }

  static constexpr std::uint64_t mix(std::uint64_t z) noexcept {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }

  std::uint64_t key_;
};

}  // namespace slipd
