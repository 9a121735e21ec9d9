// Angles and their projection on a basis, taxel by taxel: loops that exist once for each instruction set
// (alpha_kernels.cpp, built several times with the flags in CMakeLists.txt) and are chosen at run time. Any
// thread; nothing here allocates.
#pragma once

#include <cstddef>
#include <span>

#include "core/patch/disc_kernels.hpp"
#include "paper/dataset/alpha.hpp"

namespace slipd {

// Of the taxels where the angle is taken.
struct AngleSums {
  double squares = 0;                  // of the angles
  double inverse_squares_per_pa2 = 0;  // of the pressures
  std::size_t taken = 0;
};

struct AlphaKernels {
  using Runs = std::span<const TaxelRun>;
  static constexpr std::size_t kTogether = 8;  // coordinates of a projection
  const char* name;
  void (*frame)(const TaxelView&, const AlphaMask&, float* alpha) noexcept;  // places are not looked at
  void (*ratio)(const float* ratio, float* alpha, std::size_t count) noexcept;
  // Writes the angles of the runs' taxels, each at its number.
  AngleSums (*angles)(const TaxelView&, Runs, const AlphaMask&, float* alpha) noexcept;
  // out[k] = sum of alpha[i] basis[i stride + k], k < kTogether, over the runs. Single precision.
  void (*project)(const float* alpha, Runs, const float* basis, std::size_t stride, float* out) noexcept;
  static const AlphaKernels baseline, avx2, avx512;  // chosen by best_kernels
};

}  // namespace slipd
