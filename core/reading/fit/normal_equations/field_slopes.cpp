#include "core/reading/fit/normal_equations/field_slopes.hpp"

#include <algorithm>
#include <array>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

using contact::LayerTensor;
using Sheet = contact::SubsurfaceSheet;

// Columns, as SubsurfaceFit::Unknown.
enum Column : std::uint8_t {
  at_x,
  at_y,
  at_size,
  at_peak,
  at_load,
  at_margin,
  at_direction,
  at_depth,
  at_along,
  at_across,
  columns
};

template <bool kElliptic>
constexpr std::size_t kUnknowns = kElliptic ? columns : at_along;

// kGrowsBoth: a round dome's row d_a is of one axis alone, as it is without a skin.
template <bool kElliptic, bool kSymmetric, bool kGrowsBoth>
[[gnu::always_inline]] inline void fill_slopes(const FieldSlopes& by, std::size_t first, std::size_t count,
                                               SlopeBlock<kUnknowns<kElliptic>>& block) noexcept {
  constexpr std::size_t kTaxels = SlopeBlock<kUnknowns<kElliptic>>::kTaxels;
  const std::size_t n = by.count;
  const double c = by.c, s = by.s, p = by.peak, q = by.shear, k = by.k;
#pragma omp simd
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t i = first + j;
    const auto put = [&](std::size_t column, double normal, double x, double y)
        __attribute__((always_inline)) {
      double* const to = &block.column[column][0][j];
      to[0] = by.per_normal * normal;
      to[kTaxels] = by.per_shear * x;
      to[2 * kTaxels] = by.per_shear * y;
    };
    const auto at = [&](const FieldRows& rows, Sheet::Of of) __attribute__((always_inline)) {
      if constexpr (kSymmetric) return rows.symmetric_at(of, i);
      return rows.at(of, i);
    };
    const auto moved = [&](const LayerTensor& o, const LayerTensor& in) __attribute__((always_inline)) {
      return sensed_of(p, o, q, c, s, combined(1, o, -k, in));
    };
    const LayerTensor o = at(by.outer, Sheet::value), in = at(by.inner, Sheet::value),
                      m = combined(1, o, -k, in);
    const Sensed all = sensed_of(p, o, q, c, s, m), shear = sensed_of(0, o, 1, c, s, m),
                 turned = sensed_of(0, o, q, -s, c, m);
    put(kUnknowns<kElliptic>, all.n - by.data[i], all.x - by.data[n + i], all.y - by.data[2 * n + i]);
    const Sensed mu = moved(at(by.outer, Sheet::d_u), at(by.inner, Sheet::d_u)),
                 mv = moved(at(by.outer, Sheet::d_v), at(by.inner, Sheet::d_v));
    put(at_x, -mu.n, -mu.x, -mu.y);
    put(at_y, -mv.n, -mv.x, -mv.y);
    const LayerTensor oa = at(by.outer, Sheet::d_a), ia = at(by.inner, Sheet::d_a);
    LayerTensor so = combined(by.wide.a_m, oa, 0, oa), si = combined(by.narrow.a_m, ia, 0, ia);
    if constexpr (kElliptic) {
      const LayerTensor ob = at(by.outer, Sheet::d_b), ib = at(by.inner, Sheet::d_b);
      const Sensed longer = moved(combined(0.5 * by.wide.a_m, oa, -0.5 * by.wide.b_m, ob),
                                  combined(0.5 * by.narrow.a_m, ia, -0.5 * by.narrow.b_m, ib)),
                   angle = moved(at(by.outer, Sheet::d_angle), at(by.inner, Sheet::d_angle));
      const double x = by.c2 * by.turn, y = -by.s2 * by.turn;
      put(at_along, by.c2 * longer.n + y * angle.n, by.c2 * longer.x + y * angle.x,
          by.c2 * longer.y + y * angle.y);
      put(at_across, by.s2 * longer.n + x * angle.n, by.s2 * longer.x + x * angle.x,
          by.s2 * longer.y + x * angle.y);
      so = combined(1, so, by.wide.b_m, ob);
      si = combined(1, si, by.narrow.b_m, ib);
    } else if constexpr (kGrowsBoth) {
      so = combined(1, so, by.wide.b_m, at(by.outer, Sheet::d_b));
      si = combined(1, si, by.narrow.b_m, at(by.inner, Sheet::d_b));
    }
    const Sensed grown = moved(so, si), by_k = sensed_of(0, o, q, c, s, combined(-1, in, -1, si));
    put(at_size, by.per_size * grown.n, by.per_size * grown.x, by.per_size * grown.y);
    put(at_peak, all.n / p, all.x / p, all.y / p);
    put(at_load, p / by.rest * shear.n, p / by.rest * shear.x, p / by.rest * shear.y);
    put(at_margin, q / by.rest * shear.n + by.dk * by_k.n, q / by.rest * shear.x + by.dk * by_k.x,
        q / by.rest * shear.y + by.dk * by_k.y);
    put(at_direction, turned.n, turned.x, turned.y);
    const Sensed deeper = moved(at(by.outer, Sheet::d_depth), at(by.inner, Sheet::d_depth));
    put(at_depth, deeper.n, deeper.x, deeper.y);
  }
}

template <bool kElliptic, bool kSymmetric, bool kGrowsBoth = false>
[[gnu::always_inline]] inline void add_blocks(const FieldSlopes& by, ChannelProducts& products) noexcept {
  using Block = SlopeBlock<kUnknowns<kElliptic>>;
  Block block;
  SlopeSums<kUnknowns<kElliptic>> sums;
  for (std::size_t first = 0; first < by.count; first += Block::kTaxels) {
    const std::size_t count = std::min(Block::kTaxels, by.count - first);
    if (count < Block::kTaxels) block = {};
    fill_slopes<kElliptic, kSymmetric, kGrowsBoth>(by, first, count, block);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      double* const left = block.column[kUnknowns<kElliptic>][channel];
      double* const kept = by.residuals + channel * by.count + first;
      if (by.residuals_given) {
        std::copy_n(kept, count, left);
      } else {
        std::copy_n(left, count, kept);
      }
    }
    sums.add(block);
  }
  sums.total(products);
}

[[gnu::always_inline]] inline void linearise(const FieldSlopes& by, int unknowns,
                                             ChannelProducts& products) noexcept {
  if (unknowns > at_along) {
    by.symmetric ? add_blocks<true, true>(by, products) : add_blocks<true, false>(by, products);
  } else if (by.surface) {
    add_blocks<false, true, true>(by, products);
  } else {
    by.symmetric ? add_blocks<false, true>(by, products) : add_blocks<false, false>(by, products);
  }
}

// As in core/simd/inlined_loops.hpp.
struct FieldKernels {
  using Kernel = void (*)(const FieldSlopes&, int, ChannelProducts&) noexcept;
  Kernel linearised;
  static const FieldKernels baseline, avx2, avx512;  // chosen by best_kernels
};
void linearise_on_baseline(const FieldSlopes& by, int unknowns, ChannelProducts& products) noexcept {
  linearise(by, unknowns, products);
}
const FieldKernels FieldKernels::baseline{linearise_on_baseline};
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] void linearise_on_avx2(const FieldSlopes& by, int unknowns,
                                                   ChannelProducts& products) noexcept {
  linearise(by, unknowns, products);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void linearise_on_avx512(const FieldSlopes& by, int unknowns,
                                                                      ChannelProducts& products) noexcept {
  linearise(by, unknowns, products);
}
const FieldKernels FieldKernels::avx2{linearise_on_avx2};
const FieldKernels FieldKernels::avx512{linearise_on_avx512};
#endif

}  // namespace

void choose_field_loops() noexcept {
  best_kernels<FieldKernels>();
}

void linearise_field(const FieldSlopes& by, int unknowns, ChannelProducts& products) noexcept {
  best_kernels<FieldKernels>().linearised(by, unknowns, products);
}

}  // namespace slipd
