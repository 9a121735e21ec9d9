#include "core/estimate/imprint_slopes.hpp"

#include <algorithm>
#include <array>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

using contact::LayerTensor;
using Sheet = contact::SubsurfaceSheet;

// Columns, as ImprintFit::Unknown.
enum Column : std::uint8_t {
  at_x,
  at_y,
  at_size,
  at_peak,
  at_load,
  at_margin,
  at_direction,
  at_along,
  at_across
};

// Slopes of so many taxels, which stay in the processor's nearest cache: those of the three channels by each
// unknown; and their residuals.
struct SlopeBlock {
  static constexpr std::size_t kTaxels = 64, kRows = 3 * kTaxels;
  alignas(64) std::array<std::array<double, kRows>, at_across + 1> column;
  alignas(64) std::array<double, kRows> left;
};

template <bool kElliptic, bool kSymmetric>
[[gnu::always_inline]] inline void fill_slopes(const ImprintSlopes& by, std::size_t first, std::size_t count,
                                               SlopeBlock& block) noexcept {
  const std::size_t n = by.count;
  const double c = by.c, s = by.s, p = by.peak, q = by.shear, k = by.k;
#pragma omp simd
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t i = first + j;
    const auto put = [&](Column column, double normal, double x, double y) {
      double* const to = block.column[column].data() + j;
      to[0] = by.per_normal * normal;
      to[SlopeBlock::kTaxels] = by.per_shear * x;
      to[2 * SlopeBlock::kTaxels] = by.per_shear * y;
    };
    const auto at = [&](const ImprintRows& rows, Sheet::Of of) __attribute__((always_inline)) {
      if constexpr (kSymmetric) return rows.symmetric_at(of, i);
      return rows.at(of, i);
    };
    const auto moved = [&](const LayerTensor& o, const LayerTensor& in) {
      return felt_of(p, o, q, c, s, combined(1, o, -k, in));
    };
    const LayerTensor o = at(by.outer, Sheet::value), in = at(by.inner, Sheet::value),
                      m = combined(1, o, -k, in);
    const Felt all = felt_of(p, o, q, c, s, m), shear = felt_of(0, o, 1, c, s, m),
               turned = felt_of(0, o, q, -s, c, m);
    double* const left = by.residuals + i;
    left[0] = by.residuals_given ? left[0] : by.per_normal * (all.n - by.data[i]);
    left[n] = by.residuals_given ? left[n] : by.per_shear * (all.x - by.data[n + i]);
    left[2 * n] = by.residuals_given ? left[2 * n] : by.per_shear * (all.y - by.data[2 * n + i]);
    double* const left_here = block.left.data() + j;
    left_here[0] = left[0];
    left_here[SlopeBlock::kTaxels] = left[n];
    left_here[2 * SlopeBlock::kTaxels] = left[2 * n];
    const Felt mu = moved(at(by.outer, Sheet::d_u), at(by.inner, Sheet::d_u)),
               mv = moved(at(by.outer, Sheet::d_v), at(by.inner, Sheet::d_v));
    put(at_x, -mu.n, -mu.x, -mu.y);
    put(at_y, -mv.n, -mv.x, -mv.y);
    const LayerTensor oa = at(by.outer, Sheet::d_a), ia = at(by.inner, Sheet::d_a);
    LayerTensor so = combined(by.wide.a_m, oa, 0, oa), si = combined(by.narrow.a_m, ia, 0, ia);
    if constexpr (kElliptic) {
      const LayerTensor ob = at(by.outer, Sheet::d_b), ib = at(by.inner, Sheet::d_b);
      const Felt longer = moved(combined(0.5 * by.wide.a_m, oa, -0.5 * by.wide.b_m, ob),
                                combined(0.5 * by.narrow.a_m, ia, -0.5 * by.narrow.b_m, ib)),
                 angle = moved(at(by.outer, Sheet::d_angle), at(by.inner, Sheet::d_angle));
      const double x = by.c2 * by.turn, y = -by.s2 * by.turn;
      put(at_along, by.c2 * longer.n + y * angle.n, by.c2 * longer.x + y * angle.x,
          by.c2 * longer.y + y * angle.y);
      put(at_across, by.s2 * longer.n + x * angle.n, by.s2 * longer.x + x * angle.x,
          by.s2 * longer.y + x * angle.y);
      so = combined(1, so, by.wide.b_m, ob);
      si = combined(1, si, by.narrow.b_m, ib);
    } else if (by.surface) {
      so = combined(1, so, by.wide.b_m, at(by.outer, Sheet::d_b));
      si = combined(1, si, by.narrow.b_m, at(by.inner, Sheet::d_b));
    }
    const Felt grown = moved(so, si), by_k = felt_of(0, o, q, c, s, combined(-1, in, -1, si));
    put(at_size, by.per_size * grown.n, by.per_size * grown.x, by.per_size * grown.y);
    put(at_peak, all.n / p, all.x / p, all.y / p);
    put(at_load, p / by.rest * shear.n, p / by.rest * shear.x, p / by.rest * shear.y);
    put(at_margin, q / by.rest * shear.n + by.dk * by_k.n, q / by.rest * shear.x + by.dk * by_k.x,
        q / by.rest * shear.y + by.dk * by_k.y);
    put(at_direction, turned.n, turned.x, turned.y);
  }
}

[[gnu::always_inline]] inline double product(const double* one, const double* two) noexcept {
  double all = 0;
#pragma omp simd reduction(+ : all)
  for (std::size_t i = 0; i < SlopeBlock::kRows; ++i) all += one[i] * two[i];
  return all;
}

// Adds products of the columns with each other, the lower half row by row, and then with the residuals.
[[gnu::always_inline]] inline void add_products(const SlopeBlock& block, std::size_t unknowns,
                                                double* to) noexcept {
  for (std::size_t row = 0; row < unknowns; ++row) {
    for (std::size_t col = 0; col <= row; ++col)
      *to++ += product(block.column[row].data(), block.column[col].data());
  }
  for (std::size_t row = 0; row < unknowns; ++row)
    *to++ += product(block.column[row].data(), block.left.data());
}

template <bool kElliptic, bool kSymmetric>
[[gnu::always_inline]] inline void add_blocks(const ImprintSlopes& by, std::size_t unknowns,
                                              double* products) noexcept {
  SlopeBlock block;
  for (std::size_t first = 0; first < by.count; first += SlopeBlock::kTaxels) {
    const std::size_t count = std::min(SlopeBlock::kTaxels, by.count - first);
    if (count < SlopeBlock::kTaxels) block = {};
    fill_slopes<kElliptic, kSymmetric>(by, first, count, block);
    add_products(block, unknowns, products);
  }
}

[[gnu::always_inline]] inline void linearise(const ImprintSlopes& by, int unknowns,
                                             double* products) noexcept {
  const auto count = static_cast<std::size_t>(unknowns);
  std::fill_n(products, count * (count + 1) / 2 + count, 0.0);
  if (unknowns > at_along) {
    by.symmetric ? add_blocks<true, true>(by, count, products) : add_blocks<true, false>(by, count, products);
  } else {
    by.symmetric ? add_blocks<false, true>(by, count, products)
                 : add_blocks<false, false>(by, count, products);
  }
}

// As in core/contact/dome_sheet.cpp.
struct ImprintKernels {
  using Kernel = void (*)(const ImprintSlopes&, int, double*) noexcept;
  Kernel linearised;
  static const ImprintKernels baseline, avx2, avx512;  // chosen by best_kernels
};
void linearise_on_baseline(const ImprintSlopes& by, int unknowns, double* products) noexcept {
  linearise(by, unknowns, products);
}
const ImprintKernels ImprintKernels::baseline{linearise_on_baseline};
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] void linearise_on_avx2(const ImprintSlopes& by, int unknowns,
                                                   double* products) noexcept {
  linearise(by, unknowns, products);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void linearise_on_avx512(const ImprintSlopes& by, int unknowns,
                                                                      double* products) noexcept {
  linearise(by, unknowns, products);
}
const ImprintKernels ImprintKernels::avx2{linearise_on_avx2};
const ImprintKernels ImprintKernels::avx512{linearise_on_avx512};
#endif

}  // namespace

void choose_imprint_loops() noexcept {
  best_kernels<ImprintKernels>();
}

void linearise_imprint(const ImprintSlopes& by, int unknowns, double* products) noexcept {
  best_kernels<ImprintKernels>().linearised(by, unknowns, products);
}

}  // namespace slipd
