#include "core/reading/fit/normal_equations/design_columns.hpp"

#include <algorithm>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

using Sheet = contact::SubsurfaceSheet;

[[gnu::always_inline]] inline void fill(const DesignColumn& of, std::size_t n, double* to) noexcept {
  const SensedRows &one = of.dome, &two = of.other;
  const double p = of.pressed_pa, x = of.pulled_x_pa, y = of.pulled_y_pa, x2 = of.other_x_pa,
               y2 = of.other_y_pa;
#pragma omp simd
  for (std::size_t i = 0; i < n; ++i) {
    to[i] = of.per_normal * (p * one[Sheet::nn][i] + x * one[Sheet::nx][i] + y * one[Sheet::ny][i] +
                             x2 * two[Sheet::nx][i] + y2 * two[Sheet::ny][i]);
    to[n + i] = of.per_shear * (p * one[Sheet::xn][i] + x * one[Sheet::xx][i] + y * one[Sheet::xy][i] +
                                x2 * two[Sheet::xx][i] + y2 * two[Sheet::xy][i]);
    to[2 * n + i] = of.per_shear * (p * one[Sheet::yn][i] + x * one[Sheet::xy][i] + y * one[Sheet::yy][i] +
                                    x2 * two[Sheet::xy][i] + y2 * two[Sheet::yy][i]);
  }
}

[[gnu::always_inline]] inline void multiply(std::span<const double* const> columns, std::size_t rows,
                                            double* products) noexcept {
  for (std::size_t row = 0; row < columns.size(); ++row) {
    const double* const one = columns[row];
    for (std::size_t col = 0; col <= row; col += 2) {
      const double *const two = columns[col], *const three = columns[std::min(col + 1, row)];
      double first = 0, second = 0;
#pragma omp simd reduction(+ : first, second)
      for (std::size_t i = 0; i < rows; ++i) {
        first += one[i] * two[i];
        second += one[i] * three[i];
      }
      *products++ = first;
      if (col < row) *products++ = second;
    }
  }
}

// As in core/simd/inlined_loops.hpp.
struct ColumnKernels {
  void (*fill)(const DesignColumn&, std::size_t, double*) noexcept;
  void (*multiply)(std::span<const double* const>, std::size_t, double*) noexcept;
  static const ColumnKernels baseline, avx2, avx512;  // chosen by best_kernels
};
void fill_on_baseline(const DesignColumn& column, std::size_t count, double* to) noexcept {
  fill(column, count, to);
}
void multiply_on_baseline(std::span<const double* const> columns, std::size_t rows,
                          double* products) noexcept {
  multiply(columns, rows, products);
}
const ColumnKernels ColumnKernels::baseline{fill_on_baseline, multiply_on_baseline};
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] void fill_on_avx2(const DesignColumn& column, std::size_t count,
                                              double* to) noexcept {
  fill(column, count, to);
}
[[gnu::target("avx2,fma")]] void multiply_on_avx2(std::span<const double* const> columns, std::size_t rows,
                                                  double* products) noexcept {
  multiply(columns, rows, products);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void fill_on_avx512(const DesignColumn& column,
                                                                 std::size_t count, double* to) noexcept {
  fill(column, count, to);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void multiply_on_avx512(std::span<const double* const> columns,
                                                                     std::size_t rows,
                                                                     double* products) noexcept {
  multiply(columns, rows, products);
}
const ColumnKernels ColumnKernels::avx2{fill_on_avx2, multiply_on_avx2};
const ColumnKernels ColumnKernels::avx512{fill_on_avx512, multiply_on_avx512};
#endif

}  // namespace

SensedRows sensed_rows(const Sheet& sheet, Sheet::Of of) noexcept {
  SensedRows rows;
  for (std::size_t c = 0; c < rows.size(); ++c)
    rows[c] = sheet.row(of, static_cast<Sheet::Component>(c)).data();
  return rows;
}

void fill_sensed(const DesignColumn& column, std::size_t count, double* to) noexcept {
  best_kernels<ColumnKernels>().fill(column, count, to);
}

void multiply_columns(std::span<const double* const> columns, std::size_t rows, double* products) noexcept {
  best_kernels<ColumnKernels>().multiply(columns, rows, products);
}

}  // namespace slipd
