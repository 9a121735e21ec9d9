#include "core/reading/fit/normal_equations/axisymmetric_normal_equations.hpp"

#include <algorithm>
#include <cmath>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

using Sheet = contact::SubsurfaceSheet;
using enum RadialFieldTable::Function;

// Sides over depth up to which a square's mean over all directions stands for its mean.
constexpr double kExactSides = 0.7, kRoughSides = 1.4;

// Into which a side is cut, for a mean over all directions of each.
std::size_t parts_of(double side_m, double depth_m, double most_sides) noexcept {
  if (!(depth_m > 0)) return 1;
  return static_cast<std::size_t>(std::max(1.0, std::ceil(side_m / (depth_m * most_sides) - 1e-9)));
}

constexpr std::size_t kBlock = SlopeBlock<AxisymmetricNormalEquations::kUnknowns>::kTaxels;

struct Summing {
  const RoundTask* task;
  const double* table;
  double x, y, per_step, last, part_m, per_radius;
  std::size_t parts;
  double p, q, k, rest, dk, c, s;
};

// A block of taxels: its slopes and the functions there.
struct Block {
  SlopeBlock<AxisymmetricNormalEquations::kUnknowns> slopes;
  alignas(64) double along_x[kBlock], along_y[kBlock], per_r[kBlock], part[kBlock];
  alignas(64) double value[kBlock][RadialFieldTable::kFunctions];
  alignas(64) double slope[kBlock][8];
  int interval[kBlock];
};

[[gnu::always_inline]] inline void locate(const Summing& by, std::size_t first, std::size_t count, double du,
                                          double dv, Block& block) noexcept {
  const double* const px = by.task->x_m + first;
  const double* const py = by.task->y_m + first;
  constexpr double kLeast = 1e-6;  // of a step: the direction at the centre is any
#pragma omp simd
  for (std::size_t i = 0; i < count; ++i) {
    const double x = px[i] - by.x + du, y = py[i] - by.y + dv;
    const double r = std::max(std::sqrt(x * x + y * y), kLeast / by.per_step), per_r = 1 / r;
    block.along_x[i] = x * per_r;
    block.along_y[i] = y * per_r;
    block.per_r[i] = per_r;
    const double place = std::min(r * by.per_step, by.last);
    block.interval[i] = static_cast<int>(place);
    block.part[i] = place - block.interval[i];
  }
}

// Hermite's cubics, all functions of a taxel side by side.
[[gnu::always_inline]] inline void interpolate(const Summing& by, std::size_t count, Block& block) noexcept {
  constexpr std::size_t kFunctions = RadialFieldTable::kFunctions;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = block.part[i], w = t * t * (3 - 2 * t), s0 = t * (1 - t) * (1 - t), s1 = t * t * (t - 1);
    const double dw = 6 * t * (1 - t) * by.per_step, ds0 = (1 - t) * (1 - 3 * t) * by.per_step,
                 ds1 = t * (3 * t - 2) * by.per_step;
    const double* const low =
        by.table + static_cast<std::size_t>(block.interval[i]) * RadialFieldTable::kPerNode;
    const double* const high = low + RadialFieldTable::kPerNode;
    double* const value = block.value[i];
#pragma omp simd
    for (std::size_t f = 0; f < kFunctions; ++f)
      value[f] = low[f] + w * (high[f] - low[f]) + s0 * low[kFunctions + f] + s1 * high[kFunctions + f];
    double* const slope = block.slope[i];
#pragma omp simd
    for (std::size_t f = 0; f < 8; ++f)
      slope[f] = dw * (high[f] - low[f]) + ds0 * low[kFunctions + f] + ds1 * high[kFunctions + f];
  }
}

// Components along the radius and across it.
struct Polar {
  double n, r, t;
};

[[gnu::always_inline]] inline void add_columns(const Summing& by, std::size_t count, double weight,
                                               Block& block) noexcept {
  const double p = by.p, q = by.q, wn = weight * by.task->per_normal, ws = weight * by.task->per_shear;
#pragma omp simd
  for (std::size_t i = 0; i < count; ++i) {
    const double ex = block.along_x[i], ey = block.along_y[i], per_r = block.per_r[i];
    const double* const f = block.value[i];
    const double* const d = block.slope[i];
    const double er = by.c * ex + by.s * ey, et = by.s * ex - by.c * ey;  // of the pull
    const auto put = [&](std::size_t which, const Polar& of) __attribute__((always_inline)) {
      auto& column = block.slopes.column[which];
      column[0][i] += wn * of.n;
      column[1][i] += ws * (of.r * ex - of.t * ey);
      column[2][i] += ws * (of.r * ey + of.t * ex);
    };
    const Polar shear{er * f[m_nr], er * f[m_rr], et * f[m_tt]};
    const Polar all{p * f[o_nn] + q * shear.n, p * f[o_rn] + q * shear.r, q * shear.t};
    put(AxisymmetricNormalEquations::kUnknowns, all);
    // By r, and by the angle over r.
    const Polar out{p * d[o_nn] + q * er * d[m_nr], p * d[o_rn] + q * er * d[m_rr], q * et * d[m_tt]};
    const Polar around{per_r * q * et * f[m_nr], per_r * (q * et * f[m_rr] - all.t),
                       per_r * (all.r - q * er * f[m_tt])};
    put(0, {ey * around.n - ex * out.n, ey * around.r - ex * out.r, ey * around.t - ex * out.t});
    put(1, {-ex * around.n - ey * out.n, -ex * around.r - ey * out.r, -ex * around.t - ey * out.t});
    const Polar grown{p * f[size_o_nn] + q * er * f[size_m_nr], p * f[size_o_rn] + q * er * f[size_m_rr],
                      q * et * f[size_m_tt]};
    put(2, {by.per_radius * grown.n, by.per_radius * grown.r, by.per_radius * grown.t});
    put(3, {all.n / p, all.r / p, all.t / p});
    const double by_load = p / by.rest, by_gamma = q / by.rest, by_k = by.dk * q;
    put(4, {by_load * shear.n, by_load * shear.r, by_load * shear.t});
    put(5, {by_gamma * shear.n + by_k * er * f[k_nr], by_gamma * shear.r + by_k * er * f[k_rr],
            by_gamma * shear.t + by_k * et * f[k_tt]});
    put(6, {-q * et * f[m_nr], -q * et * f[m_rr], q * er * f[m_tt]});
    // As in subsurface.cpp, but with what the width of a taxel adds left out: less than a tenth of it.
    const double r = 1 / per_r;
    put(7, {-grown.n - r * out.n, -grown.r - r * out.r, -grown.t - r * out.t});
  }
}

[[gnu::always_inline]] inline void sum_block(
    const Summing& by, std::size_t first, std::size_t count, Block& block,
    SlopeSums<AxisymmetricNormalEquations::kUnknowns>& sums) noexcept {
  const RoundTask& task = *by.task;
  block.slopes = {};
  const auto parts = static_cast<double>(by.parts), weight = 1 / (parts * parts);
  for (std::size_t i = 0; i < by.parts; ++i) {
    for (std::size_t j = 0; j < by.parts; ++j) {
      const double du = (static_cast<double>(i) + 0.5 - 0.5 * parts) * by.part_m,
                   dv = (static_cast<double>(j) + 0.5 - 0.5 * parts) * by.part_m;
      locate(by, first, count, du, dv, block);
      interpolate(by, count, block);
      add_columns(by, count, weight, block);
    }
  }
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const double per_noise = channel == 0 ? task.per_normal : task.per_shear;
    const double* const data = task.data_pa + channel * task.count + first;
    double* const to = task.residuals + channel * task.count + first;
    double* const left = block.slopes.column[AxisymmetricNormalEquations::kUnknowns][channel];
#pragma omp simd
    for (std::size_t i = 0; i < count; ++i) {
      left[i] -= per_noise * data[i];
      to[i] = left[i];
    }
  }
  sums.add(block.slopes);
}

[[gnu::always_inline]] inline void sum_all(const Summing& by, ChannelProducts& products) noexcept {
  Block block;
  SlopeSums<AxisymmetricNormalEquations::kUnknowns> sums;
  for (std::size_t first = 0; first < by.task->count; first += kBlock)
    sum_block(by, first, std::min(kBlock, by.task->count - first), block, sums);
  sums.total(products);
}

// As in core/simd/inlined_loops.hpp.
struct AxisymmetricKernels {
  void (*sum)(const Summing&, ChannelProducts&) noexcept;
  static const AxisymmetricKernels baseline, avx2, avx512;  // chosen by best_kernels
};
void sum_on_baseline(const Summing& by, ChannelProducts& products) noexcept {
  sum_all(by, products);
}
const AxisymmetricKernels AxisymmetricKernels::baseline{sum_on_baseline};
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] void sum_on_avx2(const Summing& by, ChannelProducts& products) noexcept {
  sum_all(by, products);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void sum_on_avx512(const Summing& by,
                                                                ChannelProducts& products) noexcept {
  sum_all(by, products);
}
const AxisymmetricKernels AxisymmetricKernels::avx2{sum_on_avx2};
const AxisymmetricKernels AxisymmetricKernels::avx512{sum_on_avx512};
#endif

}  // namespace

AxisymmetricNormalEquations::AxisymmetricNormalEquations(double side_m, double depth_m,
                                                         std::optional<double> bonded_poisson)
    : side_m_(side_m),
      depth_m_(depth_m),
      parts_{parts_of(side_m, depth_m, kExactSides), parts_of(side_m, depth_m, kRoughSides)},
      table_(depth_m, bonded_poisson) {
  best_kernels<AxisymmetricKernels>();  // not first within a fit
}

bool AxisymmetricNormalEquations::pays(std::size_t count, double reach_m, Sheet::Detail detail,
                                       std::size_t sheet_points) const noexcept {
  if (!(depth_m_ > 0)) return false;
  const double nodes = reach_m / table_.step_m(detail) + 2 + RadialFieldTable::kGhosts;
  if (!(nodes < static_cast<double>(RadialFieldTable::kMostNodes))) return false;
  // Measured: a table's point takes as long as a sheet's, a taxel in it and one of two sheets a little
  // longer.
  constexpr double kTaxel = 1.2, kOfSheets = 1.5;
  const auto parts = static_cast<double>(parts_along(detail)), points = static_cast<double>(sheet_points);
  return 2 * static_cast<double>(RadialFieldTable::points(detail)) * nodes <
         static_cast<double>(count) * (2 * points * points + kOfSheets - kTaxel * parts * parts);
}

void AxisymmetricNormalEquations::linearise(const RoundTrial& trial, double reach_m, Sheet::Detail detail,
                                            const RoundTask& task, ChannelProducts& products) noexcept {
  const std::size_t parts = parts_along(detail);
  const double part_m = side_m_ / static_cast<double>(parts), step_m = table_.step_m(detail);
  const auto nodes = std::min(static_cast<std::size_t>(reach_m / step_m) + 2 + RadialFieldTable::kGhosts,
                              std::size_t{RadialFieldTable::kMostNodes});
  table_.fill(trial, detail, nodes, part_m);
  const double k = std::cbrt(trial.gamma), rest = 1 - trial.gamma;
  best_kernels<AxisymmetricKernels>().sum(
      {.task = &task,
       .table = table_.data(),
       .x = trial.x_m,
       .y = trial.y_m,
       .per_step = 1 / step_m,
       .last = static_cast<double>(nodes - RadialFieldTable::kGhosts - 1) - 1e-9,
       .part_m = part_m,
       .per_radius = 1 / trial.radius_m,
       .parts = parts,
       .p = trial.peak_pa,
       .q = trial.peak_pa * trial.load / rest,
       .k = k,
       .rest = rest,
       .dk = 1 / (3 * k * k),
       .c = std::cos(trial.direction_rad),
       .s = std::sin(trial.direction_rad)},
      products);
}

}  // namespace slipd
