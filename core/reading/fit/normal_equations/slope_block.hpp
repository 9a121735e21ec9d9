// Slopes of a few taxels' residuals by the unknowns of a fit, and the sums of their products, which normal
// equations are made of. For loops that exist once for each instruction set: always inlined.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace slipd {

// Sums over taxels of the products of slopes with each other, the lower half row by row, then of the slopes
// with the residuals, and last of the residuals with themselves.
struct ChannelProducts {
  static constexpr std::size_t kMostUnknowns = 10;
  using Products = std::array<double, (kMostUnknowns + 1) * (kMostUnknowns + 2) / 2>;
  Products pressure{}, shear{};  // shear: both components
};

// Those of up to kTaxels taxels, which stay in the processor's nearest cache; behind the unknowns' columns
// that of the residuals.
template <std::size_t kUnknowns>
struct SlopeBlock {
  static constexpr std::size_t kTaxels = 64;
  alignas(64) double column[kUnknowns + 1][3][kTaxels];
};

// Adds blocks up.
template <std::size_t kUnknowns>
class SlopeSums {
 public:
  // Rows behind the taxels in use are 0.
  [[gnu::always_inline]] void add(const SlopeBlock<kUnknowns>& block) noexcept {
    add_rows<1>(&block.column[0][0][0], pressure_);
    add_rows<2>(&block.column[0][1][0], shear_);
  }
  [[gnu::always_inline]] void total(ChannelProducts& to) const noexcept {
    for (std::size_t i = 0; i < kPairs; ++i) {
      to.pressure[i] = to.shear[i] = 0;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        to.pressure[i] += pressure_[i][lane];
        to.shear[i] += shear_[i][lane];
      }
    }
  }

 private:
  static constexpr std::size_t kLanes = 8, kColumns = kUnknowns + 1, kTogether = 4,
                               kPairs = kColumns * (kColumns + 1) / 2;
  using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));
  using Sums = std::array<Lanes, kPairs>;

  template <std::size_t kChannels>
  [[gnu::always_inline]] static void add_rows(const double* columns, Sums& sums) noexcept {
    constexpr std::size_t kTaxels = SlopeBlock<kUnknowns>::kTaxels, kStride = 3 * kTaxels;
    std::size_t first = 0;
    for (std::size_t row = 0; row < kColumns; first += ++row) {
      for (std::size_t col = 0; col <= row; col += kTogether) {
        const std::size_t count = std::min(kTogether, row + 1 - col);
        const double* const one = columns + row * kStride;
        const double* const other[kTogether] = {
            columns + col * kStride, columns + std::min(col + 1, row) * kStride,
            columns + std::min(col + 2, row) * kStride, columns + std::min(col + 3, row) * kStride};
        Lanes part[kTogether] = {};
        for (std::size_t i = 0; i < kChannels * kTaxels; i += kLanes) {
          Lanes left, right;
          __builtin_memcpy(&left, one + i, sizeof left);
          for (std::size_t j = 0; j < kTogether; ++j) {
            __builtin_memcpy(&right, other[j] + i, sizeof right);
            part[j] += left * right;
          }
        }
        for (std::size_t j = 0; j < count; ++j) sums[first + col + j] += part[j];
      }
    }
  }

  Sums pressure_{}, shear_{};
};

}  // namespace slipd
