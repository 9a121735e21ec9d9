#include "core/reading/fit/normal_equations/radial_field_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

using Sheet = contact::SubsurfaceSheet;
using enum RadialFieldTable::Function;

constexpr bool is_odd(std::size_t function) noexcept {
  return function == o_rn || function == m_nr || function == size_o_rn || function == size_m_nr ||
         function == k_nr;
}

// The mean over a square, all directions of its sides alike, by points about its centre. They lie in pairs on
// both sides of the line through the contact's centre, of which one stands for both. Places in sides.
struct SquareMean {
  static constexpr std::size_t kMost = 6;
  std::size_t points;
  std::array<double, kMost> along, across, weight;
};
constexpr double kRing = 0.48304589153964794, kCorner = 0.34156502553198665;  // sqrt(7/30), sqrt(7/60)
constexpr double kGauss = 0.28867513459481287;                                // sqrt(1/12)
// Exact to the fourth power of the side, and to the second.
constexpr SquareMean kExactMean{.points = 6,
                                .along = {0, kRing, kCorner, 0, -kCorner, -kRing},
                                .across = {0, 0, kCorner, kRing, kCorner, 0},
                                .weight = {2.0 / 7, 5.0 / 56, 5.0 / 28, 5.0 / 28, 5.0 / 28, 5.0 / 56}};
constexpr SquareMean kRoughMean{
    .points = 2, .along = {kGauss, -kGauss}, .across = {kGauss, kGauss}, .weight = {0.5, 0.5}};
const SquareMean& mean_of(Sheet::Detail detail) noexcept {
  return detail == Sheet::Detail::exact ? kExactMean : kRoughMean;
}

struct Filling {
  const Sheet* sheet;
  const SquareMean* mean;
  double* functions;  // `used` lists of `stride` nodes; the first kGhosts are at negative r
  double* table;
  std::size_t stride, nodes;
  double wide_m, narrow_m, k;
};

// The mean of a component over the points about each node.
[[gnu::always_inline]] inline void add_mean(const Filling& by, Sheet::Of of, Sheet::Component component,
                                            double share, RadialFieldTable::Function to) noexcept {
  const double* const from = by.sheet->row(of, component).data();
  const std::size_t count = by.nodes;
  double* const out = by.functions + to * by.stride + RadialFieldTable::kGhosts;
  for (std::size_t point = 0; point < by.mean->points; ++point) {
    const double weight = share * by.mean->weight[point];
#pragma omp simd
    for (std::size_t j = 0; j < count; ++j) out[j] += weight * from[point * count + j];
  }
}

[[gnu::always_inline]] inline void fill_outer(const Filling& by) noexcept {
  const double a = by.wide_m;
  add_mean(by, Sheet::value, Sheet::nn, 1, o_nn);
  add_mean(by, Sheet::value, Sheet::xn, 1, o_rn);
  add_mean(by, Sheet::value, Sheet::nx, 1, m_nr);
  add_mean(by, Sheet::value, Sheet::xx, 1, m_rr);
  add_mean(by, Sheet::value, Sheet::yy, 1, m_tt);
  add_mean(by, Sheet::d_a, Sheet::nn, a, size_o_nn);
  add_mean(by, Sheet::d_a, Sheet::xn, a, size_o_rn);
  add_mean(by, Sheet::d_a, Sheet::nx, a, size_m_nr);
  add_mean(by, Sheet::d_a, Sheet::xx, a, size_m_rr);
  add_mean(by, Sheet::d_a, Sheet::yy, a, size_m_tt);
}

[[gnu::always_inline]] inline void fill_inner(const Filling& by) noexcept {
  const double a = by.narrow_m, k = by.k;
  const auto add = [&](Sheet::Component component, RadialFieldTable::Function moved,
                       RadialFieldTable::Function grown, RadialFieldTable::Function by_k)
      __attribute__((always_inline)) {
    add_mean(by, Sheet::value, component, -k, moved);
    add_mean(by, Sheet::d_a, component, -k * a, grown);
    add_mean(by, Sheet::value, component, -1, by_k);
    add_mean(by, Sheet::d_a, component, -a, by_k);
  };
  add(Sheet::nx, m_nr, size_m_nr, k_nr);
  add(Sheet::xx, m_rr, size_m_rr, k_rr);
  add(Sheet::yy, m_tt, size_m_tt, k_tt);
}

// Slopes by central differences of the fourth order, over one step.
[[gnu::always_inline]] inline void fill_table(const Filling& by) noexcept {
  constexpr std::size_t kGhosts = RadialFieldTable::kGhosts;
  for (std::size_t f = 0; f < RadialFieldTable::used; ++f) {
    double* const list = by.functions + f * by.stride;
    const double sign = is_odd(f) ? -1 : 1;
    for (std::size_t j = 1; j <= kGhosts; ++j) list[kGhosts - j] = sign * list[kGhosts + j];
    for (std::size_t j = 0; j + kGhosts < by.nodes; ++j) {
      const double* const at = list + kGhosts + j;
      double* const to = by.table + j * RadialFieldTable::kPerNode + f;
      to[0] = at[0];
      to[RadialFieldTable::kFunctions] = (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / 12;
    }
  }
}

// As in core/simd/inlined_loops.hpp.
struct TableKernels {
  using Kernel = void (*)(const Filling&) noexcept;
  Kernel outer, inner;
  static const TableKernels baseline, avx2, avx512;  // chosen by best_kernels
};
void outer_on_baseline(const Filling& by) noexcept {
  fill_outer(by);
}
void inner_on_baseline(const Filling& by) noexcept {
  fill_inner(by);
  fill_table(by);
}
const TableKernels TableKernels::baseline{outer_on_baseline, inner_on_baseline};
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] void outer_on_avx2(const Filling& by) noexcept {
  fill_outer(by);
}
[[gnu::target("avx2,fma")]] void inner_on_avx2(const Filling& by) noexcept {
  fill_inner(by);
  fill_table(by);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void outer_on_avx512(const Filling& by) noexcept {
  fill_outer(by);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void inner_on_avx512(const Filling& by) noexcept {
  fill_inner(by);
  fill_table(by);
}
const TableKernels TableKernels::avx2{outer_on_avx2, inner_on_avx2};
const TableKernels TableKernels::avx512{outer_on_avx512, inner_on_avx512};
#endif

}  // namespace

RadialFieldTable::RadialFieldTable(double depth_m, std::optional<double> bonded_poisson)
    : sheet_(depth_m > 0 ? SquareMean::kMost * kMostNodes : 0, 0, depth_m, bonded_poisson) {
  if (!(depth_m > 0)) return;
  u_.resize(SquareMean::kMost * kMostNodes);
  v_.resize(SquareMean::kMost * kMostNodes);
  functions_.resize(Function::used * (kMostNodes + kGhosts));
  table_.resize(kPerNode * kMostNodes);
  best_kernels<TableKernels>();  // not first within a fit
}

std::size_t RadialFieldTable::memory_bytes() const noexcept {
  return sheet_.memory_bytes() + sizeof(double) * (2 * u_.size() + functions_.size() + table_.size());
}

double RadialFieldTable::step_m(Detail detail) const noexcept {
  return (detail == Detail::exact ? 0.15 : 0.3) * sheet_.depth_m();
}

std::size_t RadialFieldTable::points(Detail detail) noexcept {
  return mean_of(detail).points;
}

void RadialFieldTable::fill(const RoundTrial& trial, Detail detail, std::size_t nodes,
                            double square_m) noexcept {
  const SquareMean& mean = mean_of(detail);
  const double step = step_m(detail);
  for (std::size_t point = 0; point < mean.points; ++point) {
    for (std::size_t j = 0; j < nodes; ++j) {
      u_[point * nodes + j] = static_cast<double>(j) * step + square_m * mean.along[point];
      v_[point * nodes + j] = square_m * mean.across[point];
    }
  }
  const double k = std::cbrt(trial.gamma), a = trial.radius_m;
  std::fill(functions_.begin(), functions_.end(), 0.0);
  const Filling filling{.sheet = &sheet_,
                        .mean = &mean,
                        .functions = functions_.data(),
                        .table = table_.data(),
                        .stride = kMostNodes + kGhosts,
                        .nodes = nodes,
                        .wide_m = a,
                        .narrow_m = k * a,
                        .k = k};
  const std::span<const double> u(u_.data(), mean.points * nodes), v(v_.data(), mean.points * nodes);
  const TableKernels& kernels = best_kernels<TableKernels>();
  sheet_.evaluate({a, a, 0}, u, v, Detail::centre);
  kernels.outer(filling);
  sheet_.evaluate({k * a, k * a, 0}, u, v, Detail::centre);
  kernels.inner(filling);
}

}  // namespace slipd
