#include "core/contact/subsurface/dome_sheet.hpp"

#include <cmath>
#include <numbers>

#include "core/contact/subsurface/dome.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd::contact {
namespace {

// Taxels nearer to the rim than this many sides are integrated exactly.
constexpr double kRimSides = 2.5;

struct Lists {
  const double *u, *v;
  double *value, *d_x, *d_u, *d_v;
  std::size_t count;
};

[[gnu::always_inline]] inline void exactly(double x, double side, const Lists& at) noexcept {
#pragma omp simd
  for (std::size_t i = 0; i < at.count; ++i) {
    const DomeAverage mean = dome_average(x, at.u[i], at.v[i], side);
    at.value[i] = mean.value;
    at.d_x[i] = mean.d_x;
    at.d_u[i] = mean.d_u;
    at.d_v[i] = mean.d_v;
  }
}

[[gnu::always_inline]] inline void values(double x, double side, const Lists& at) noexcept {
#pragma omp simd
  for (std::size_t i = 0; i < at.count; ++i) at.value[i] = dome_average(x, at.u[i], at.v[i], side).value;
}

// docs/theory.md §5.2: f at the taxel's centre plus what its curvature adds over the square: side^2/24 times
// the Laplacian of f = sqrt(x^2 - r^2), which is -(1/f + x^2/f^3). Derivatives likewise to first order.
// Meaningless at the rim.
[[gnu::always_inline]] inline void smoothly(double x, double side, const Lists& at) noexcept {
  const double xx = x * x, bend = side * side / 24;
#pragma omp simd
  for (std::size_t i = 0; i < at.count; ++i) {
    const double rest = xx - at.u[i] * at.u[i] - at.v[i] * at.v[i];
    const bool inside = rest > 0;
    const double f = std::sqrt(inside ? rest : 1.0), over = 1 / f, over3 = over * over * over;
    const double slope = over + bend * over3 * (1 + 3 * xx * over * over);  // -d/d(r^2/2)
    at.value[i] = inside ? f - bend * (over + xx * over3) : 0.0;
    at.d_x[i] = inside ? x * (over + bend * over3 * (3 * xx * over * over - 1)) : 0.0;
    at.d_u[i] = inside ? -at.u[i] * slope : 0.0;
    at.d_v[i] = inside ? -at.v[i] * slope : 0.0;
  }
}

// Not a file built once for each instruction set, as other loops are: these call the standard library, which
// is inlined into a function for what that function is built for.
template <auto kLoop>
void on_baseline(double x, double side, const Lists& at) noexcept {
  kLoop(x, side, at);
}
#if defined(__x86_64__)
template <auto kLoop>
[[gnu::target("avx2,fma")]] void on_avx2(double x, double side, const Lists& at) noexcept {
  kLoop(x, side, at);
}
template <auto kLoop>
[[gnu::target("avx512f,avx512vl,avx512dq")]] void on_avx512(double x, double side, const Lists& at) noexcept {
  kLoop(x, side, at);
}
#endif

struct DomeKernels {
  using Kernel = void (*)(double, double, const Lists&) noexcept;
  Kernel exact, smooth, value;
  static const DomeKernels baseline, avx2, avx512;  // chosen by best_kernels
};
const DomeKernels DomeKernels::baseline{on_baseline<exactly>, on_baseline<smoothly>, on_baseline<values>};
#if defined(__x86_64__)
const DomeKernels DomeKernels::avx2{on_avx2<exactly>, on_avx2<smoothly>, on_avx2<values>};
const DomeKernels DomeKernels::avx512{on_avx512<exactly>, on_avx512<smoothly>, on_avx512<values>};
#endif

}  // namespace

DomeSheet::DomeSheet(std::size_t most, double side_m)
    : side_(side_m), u_(most), v_(most), value_(most), d_x_(most), d_u_(most), d_v_(most) {
  rim_.reserve(most);
  best_kernels<DomeKernels>();  // not first within a fit
}

void DomeSheet::evaluate(double x, std::span<const double> u, std::span<const double> v,
                         std::span<double> value, std::span<double> d_x, std::span<double> d_u,
                         std::span<double> d_v) noexcept {
  const DomeKernels& kernels = best_kernels<DomeKernels>();
  const std::size_t n = u.size();
  const double within = std::max(0.0, x - kRimSides * side_), beyond = x + side_ * (std::numbers::sqrt2 / 2);
  if (within > 0)
    kernels.smooth(x, side_, {u.data(), v.data(), value.data(), d_x.data(), d_u.data(), d_v.data(), n});
  rim_.clear();
  for (std::uint32_t i = 0; i < n; ++i) {
    const double r2 = u[i] * u[i] + v[i] * v[i];
    if (r2 < within * within) continue;
    if (r2 < beyond * beyond) {
      u_[rim_.size()] = u[i];
      v_[rim_.size()] = v[i];
      rim_.push_back(i);
    } else {
      value[i] = d_x[i] = d_u[i] = d_v[i] = 0;
    }
  }
  kernels.exact(x, side_,
                {u_.data(), v_.data(), value_.data(), d_x_.data(), d_u_.data(), d_v_.data(), rim_.size()});
  for (std::size_t j = 0; j < rim_.size(); ++j) {
    value[rim_[j]] = value_[j];
    d_x[rim_[j]] = d_x_[j];
    d_u[rim_[j]] = d_u_[j];
    d_v[rim_[j]] = d_v_[j];
  }
}

void DomeSheet::exact_values(double x, double side_m, std::span<const double> u, std::span<const double> v,
                             std::span<double> value) noexcept {
  best_kernels<DomeKernels>().value(x, side_m,
                                    {u.data(), v.data(), value.data(), nullptr, nullptr, nullptr, u.size()});
}

}  // namespace slipd::contact
