// Vector types of the compiler (vector extensions), and loops over taxels with them. A vector is as wide as a
// register: GCC splits comparisons and masks of wider ones into single values, which makes these loops five
// to ten times slower. Included by files that are built once for each instruction set. They call no function
// of the standard library: an inline function exists once in the program, perhaps for another processor.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/simd/taxel_runs.hpp"

namespace slipd {
namespace {

#if defined(__AVX512F__)
constexpr std::size_t kRegisterBytes = 64;
#elif defined(__AVX2__)
constexpr std::size_t kRegisterBytes = 32;
#else
constexpr std::size_t kRegisterBytes = 16;  // SSE2, NEON
#endif

using Floats = float __attribute__((vector_size(kRegisterBytes)));
using Ints = std::int32_t __attribute__((vector_size(kRegisterBytes)));
using Half = float __attribute__((vector_size(kRegisterBytes / 2)));
using Doubles = double __attribute__((vector_size(kRegisterBytes)));

#define SLIPD_INLINE [[gnu::always_inline]] inline

constexpr std::size_t kLanes = kRegisterBytes / sizeof(float);
static_assert(kMaxLanes % kLanes == 0);
constexpr int kBlocks = 32;  // of single precision before they are added in double

SLIPD_INLINE Floats load(const float* from) noexcept {
  Floats values;
  __builtin_memcpy(&values, from, sizeof values);
  return values;
}

SLIPD_INLINE void store(float* to, const Floats& values) noexcept {
  __builtin_memcpy(to, &values, sizeof values);
}

SLIPD_INLINE Floats where(const Ints& mask, const Floats& values) noexcept {
  return reinterpret_cast<Floats>(mask & reinterpret_cast<Ints>(values));
}

// N sums at once. Each is kept in one register in single precision and added up in double after kBlocks
// blocks.
template <int N>
struct Sums {
  Floats part[N] = {};
  Doubles whole[N] = {};
  int blocks = 0;

  SLIPD_INLINE void next() noexcept {
    if (++blocks == kBlocks) flush();
  }
  SLIPD_INLINE void flush() noexcept {
    for (int i = 0; i < N; ++i) {
      Half half[2];
      __builtin_memcpy(half, &part[i], sizeof half);
      whole[i] += __builtin_convertvector(half[0], Doubles) + __builtin_convertvector(half[1], Doubles);
      part[i] = Floats{};
    }
    blocks = 0;
  }
  SLIPD_INLINE double total(int i) const noexcept {
    double sum = 0;
    for (std::size_t lane = 0; lane < kLanes / 2; ++lane) sum += whole[i][lane];
    return sum;
  }
};

// Calls body(first, mask) for blocks of kLanes taxels that cover the runs. `mask` selects the taxels of a
// block, so that each taxel of the runs is selected once.
template <typename Body>
SLIPD_INLINE void for_blocks(const TaxelRun* runs, std::size_t count, std::size_t size,
                             const Body& body) noexcept {
  Ints numbers{};
  for (std::size_t lane = 0; lane < kLanes; ++lane) numbers[lane] = static_cast<std::int32_t>(lane);
  const Ints all = numbers >= 0;
  const std::size_t last = size > kLanes ? size - kLanes : 0;  // where the last whole block begins
  for (std::size_t r = 0; r < count; ++r) {
    std::size_t i = runs[r].first;
    const std::size_t end = runs[r].end;
    for (; i + kLanes <= end; i += kLanes) body(i, all);
    if (i == end) continue;
    const std::size_t from = i < last ? i : last;
    const auto low = static_cast<std::int32_t>(i - from), high = static_cast<std::int32_t>(end - from);
    body(from, (numbers >= low) & (numbers < high));
  }
}

}  // namespace
}  // namespace slipd
