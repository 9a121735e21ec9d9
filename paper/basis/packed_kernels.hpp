// A column without its zeros, and what singular vectors need of it: loops that exist once for each
// instruction set (packed_kernels.cpp) and are chosen at run time. Training threads.
#pragma once

#include <cstddef>
#include <span>

#include "core/patch/disc_kernels.hpp"

namespace slipd {

// Rows other than those of the runs are 0; `values`: one after the other, as many as the runs have rows.
struct PackedColumn {
  std::span<const TaxelRun> runs;
  const float* values = nullptr;
};

// Matrices here have a row's values side by side, and rows so many values apart: 16, 32, 48 or 64.
struct PackedKernels {
  static constexpr std::size_t kStep = 16, kWidest = 64;
  const char* name;
  void (*project)(const PackedColumn& x, const float* q, std::size_t width, float* z) noexcept;  // z = Q' x
  void (*add_product)(const PackedColumn& x, const float* z, std::size_t width,
                      float* y) noexcept;             // Y += x z'
  static const PackedKernels baseline, avx2, avx512;  // chosen by best_kernels
};

}  // namespace slipd
