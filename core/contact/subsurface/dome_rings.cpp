#include "core/contact/subsurface/dome_rings.hpp"

#include "core/contact/subsurface/dome.hpp"
#include "core/simd/inlined_loops.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd::contact {
namespace {

struct Corners {
  const PerRing& radii;
  std::span<const double> u, v;
  double center_u, center_v;
  PerRing* out;
};

[[gnu::always_inline]] inline void integrate_loop(const Corners& at) noexcept {
  const PerRing radii = at.radii;
  for (std::size_t i = 0; i < at.u.size(); ++i) {
    const auto u = static_cast<float>(at.u[i] - at.center_u), v = static_cast<float>(at.v[i] - at.center_v);
    float* const out = at.out[i].data();
#pragma omp simd simdlen(8)
    for (std::size_t k = 0; k < kRings; ++k) out[k] = dome_corner(radii[k], u, v).value;
  }
}

struct Adding {
  const SquareRow& squares;
  RingSums& sums;
};

[[gnu::always_inline]] inline void add_loop(const Adding& task) noexcept {
  const SquareRow& row = task.squares;
  const auto per_area = static_cast<float>(row.per_area);
  RingSums sums = task.sums;
  for (std::size_t i = 0; i < row.whole.size(); ++i) {
    const PerRing &left_below = row.below[i], &below = row.below[i + 1], &left_above = row.above[i],
                  &above = row.above[i + 1];
    const double whole = row.whole[i], field = row.field[i];
#pragma omp simd simdlen(8)
    for (std::size_t k = 0; k < kRings; ++k) {
      const float dome = ((above[k] - left_above[k]) - (below[k] - left_below[k])) * per_area;
      const double ring = whole - static_cast<double>(dome);
      sums.squares[k] += ring * ring;
      sums.products[k] += ring * field;
    }
  }
  task.sums = sums;
}

struct RingKernels {
  void (*integrate)(const Corners&) noexcept;
  void (*add)(const Adding&) noexcept;
  static const RingKernels baseline, avx2, avx512;  // chosen by best_kernels
};
const RingKernels RingKernels::baseline{on_baseline<integrate_loop>, on_baseline<add_loop>};
#if defined(__x86_64__)
const RingKernels RingKernels::avx2{on_avx2<integrate_loop>, on_avx2<add_loop>};
const RingKernels RingKernels::avx512{on_avx512<integrate_loop>, on_avx512<add_loop>};
#endif

}  // namespace

void integrate_domes(const PerRing& radii, std::span<const double> u, std::span<const double> v,
                     double center_u, double center_v, std::span<PerRing> corners) noexcept {
  best_kernels<RingKernels>().integrate({radii, u, v, center_u, center_v, corners.data()});
}

void add_rings(const SquareRow& squares, RingSums& sums) noexcept {
  best_kernels<RingKernels>().add({squares, sums});
}

}  // namespace slipd::contact
