#include "core/contact/subsurface/dome_averages.hpp"

#include <cstddef>

#include "core/simd/inlined_loops.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd::contact {
namespace {

struct Squares {
  const double *u, *v;
  double *value, *d_x, *d_u, *d_v;
  std::size_t count;
  double x, side;
};

[[gnu::always_inline]] inline void fill_averages(const Squares& at) noexcept {
#pragma omp simd
  for (std::size_t i = 0; i < at.count; ++i) {
    const DomeAverage mean = dome_average(at.x, at.u[i], at.v[i], at.side);
    at.value[i] = mean.value;
    at.d_x[i] = mean.d_x;
    at.d_u[i] = mean.d_u;
    at.d_v[i] = mean.d_v;
  }
}

[[gnu::always_inline]] inline void fill_values(const Squares& at) noexcept {
#pragma omp simd
  for (std::size_t i = 0; i < at.count; ++i)
    at.value[i] = dome_average(at.x, at.u[i], at.v[i], at.side).value;
}

struct DomeKernels {
  void (*averages)(const Squares&) noexcept;
  void (*values)(const Squares&) noexcept;
  static const DomeKernels baseline, avx2, avx512;  // chosen by best_kernels
};
const DomeKernels DomeKernels::baseline{on_baseline<fill_averages>, on_baseline<fill_values>};
#if defined(__x86_64__)
const DomeKernels DomeKernels::avx2{on_avx2<fill_averages>, on_avx2<fill_values>};
const DomeKernels DomeKernels::avx512{on_avx512<fill_averages>, on_avx512<fill_values>};
#endif

}  // namespace

void average_dome(double x, double side, std::span<const double> u, std::span<const double> v,
                  const DomeAverages& out) noexcept {
  best_kernels<DomeKernels>().averages({u.data(), v.data(), out.value.data(), out.d_x.data(), out.d_u.data(),
                                        out.d_v.data(), u.size(), x, side});
}

void average_dome(double x, double side, std::span<const double> u, std::span<const double> v,
                  std::span<double> value) noexcept {
  best_kernels<DomeKernels>().values(
      {u.data(), v.data(), value.data(), nullptr, nullptr, nullptr, u.size(), x, side});
}

}  // namespace slipd::contact
