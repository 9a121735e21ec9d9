#include "core/estimate/imprint_round.hpp"

#include <algorithm>
#include <cmath>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

using Sheet = contact::SubsurfaceSheet;

// Functions of the distance r from the centre. O: of the contact's dome; M: of it less k times the stick
// zone's, which slides; size: derivative by the log of the radius; K: of M by k. nn, rn, nr, rr and tt are
// the components along the normal, the radius and across it: rn the shear along the radius of a normal
// traction, nr the pressure of a traction along the radius.
enum Function : std::uint8_t {
  o_nn,
  o_rn,
  m_nr,
  m_rr,
  m_tt,
  sloped,  // functions whose derivatives by r are needed
  size_o_nn = sloped,
  size_o_rn,
  size_m_nr,
  size_m_rr,
  size_m_tt,
  k_nr,
  k_rr,
  k_tt,
  used
};
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

// Distance of nodes over depth. Cubics between them are then within 1e-5 of the height, and 5e-4.
double step_depths(Sheet::Detail detail) noexcept {
  return detail == Sheet::Detail::exact ? 0.15 : 0.3;
}
// Sides over depth up to which a square's mean over all directions stands for its mean.
constexpr double kExactSides = 0.7, kRoughSides = 1.4;

// Into which a side is cut, for a mean over all directions of each.
std::size_t parts_of(double side_m, double depth_m, double most_sides) noexcept {
  return static_cast<std::size_t>(std::max(1.0, std::ceil(side_m / (depth_m * most_sides) - 1e-9)));
}

struct Filling {
  const Sheet* sheet;
  const SquareMean* mean;
  double* functions;  // `used` lists of `stride` nodes; the first kGhosts are at negative r
  double* table;
  std::size_t stride, nodes;
  double wide_m, narrow_m, k;
};

constexpr std::size_t kBlock = SlopeBlock<RoundImprint::kUnknowns>::kTaxels;

struct Summing {
  const RoundTask* task;
  const double* table;
  double x, y, per_step, last, part_m, per_radius;
  std::size_t parts;
  double p, q, k, rest, dk, c, s;
};

// The mean of a component over the points about each node.
[[gnu::always_inline]] inline void add_mean(const Filling& by, Sheet::Of of, Sheet::Component component,
                                            double share, Function to) noexcept {
  const double* const from = by.sheet->row(of, component).data();
  const std::size_t count = by.nodes;
  double* const out = by.functions + to * by.stride + RoundImprint::kGhosts;
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
  const auto add = [&](Sheet::Component component, Function moved, Function grown, Function by_k)
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
  constexpr std::size_t kGhosts = RoundImprint::kGhosts;
  for (std::size_t f = 0; f < Function::used; ++f) {
    double* const list = by.functions + f * by.stride;
    const double sign = is_odd(f) ? -1 : 1;
    for (std::size_t j = 1; j <= kGhosts; ++j) list[kGhosts - j] = sign * list[kGhosts + j];
    for (std::size_t j = 0; j + kGhosts < by.nodes; ++j) {
      const double* const at = list + kGhosts + j;
      double* const to = by.table + j * RoundImprint::kPerNode + f;
      to[0] = at[0];
      to[RoundImprint::kFunctions] = (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / 12;
    }
  }
}

// A block of taxels: its slopes and the functions there.
struct Block {
  SlopeBlock<RoundImprint::kUnknowns> slopes;
  alignas(64) double along_x[kBlock], along_y[kBlock], per_r[kBlock], part[kBlock];
  alignas(64) double value[kBlock][RoundImprint::kFunctions];
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
  constexpr std::size_t kFunctions = RoundImprint::kFunctions;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = block.part[i], w = t * t * (3 - 2 * t), s0 = t * (1 - t) * (1 - t), s1 = t * t * (t - 1);
    const double dw = 6 * t * (1 - t) * by.per_step, ds0 = (1 - t) * (1 - 3 * t) * by.per_step,
                 ds1 = t * (3 * t - 2) * by.per_step;
    const double* const low = by.table + static_cast<std::size_t>(block.interval[i]) * RoundImprint::kPerNode;
    const double* const high = low + RoundImprint::kPerNode;
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
    put(RoundImprint::kUnknowns, all);
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
    // As in subsurface.cpp; that a deeper taxel is a smaller one, too, is left out.
    const double r = 1 / per_r;
    put(7, {-grown.n - r * out.n, -grown.r - r * out.r, -grown.t - r * out.t});
  }
}

[[gnu::always_inline]] inline void sum_block(const Summing& by, std::size_t first, std::size_t count,
                                             Block& block,
                                             SlopeSums<RoundImprint::kUnknowns>& sums) noexcept {
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
    double* const left = block.slopes.column[RoundImprint::kUnknowns][channel];
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
  SlopeSums<RoundImprint::kUnknowns> sums;
  for (std::size_t first = 0; first < by.task->count; first += kBlock)
    sum_block(by, first, std::min(kBlock, by.task->count - first), block, sums);
  sums.total(products);
}

// As in core/contact/dome_sheet.cpp.
struct RoundKernels {
  void (*outer)(const Filling&) noexcept;
  void (*inner)(const Filling&) noexcept;
  void (*sum)(const Summing&, ChannelProducts&) noexcept;
  static const RoundKernels baseline, avx2, avx512;  // chosen by best_kernels
};
void outer_on_baseline(const Filling& by) noexcept {
  fill_outer(by);
}
void inner_on_baseline(const Filling& by) noexcept {
  fill_inner(by);
  fill_table(by);
}
void sum_on_baseline(const Summing& by, ChannelProducts& products) noexcept {
  sum_all(by, products);
}
const RoundKernels RoundKernels::baseline{outer_on_baseline, inner_on_baseline, sum_on_baseline};
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] void outer_on_avx2(const Filling& by) noexcept {
  fill_outer(by);
}
[[gnu::target("avx2,fma")]] void inner_on_avx2(const Filling& by) noexcept {
  fill_inner(by);
  fill_table(by);
}
[[gnu::target("avx2,fma")]] void sum_on_avx2(const Summing& by, ChannelProducts& products) noexcept {
  sum_all(by, products);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void outer_on_avx512(const Filling& by) noexcept {
  fill_outer(by);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void inner_on_avx512(const Filling& by) noexcept {
  fill_inner(by);
  fill_table(by);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void sum_on_avx512(const Summing& by,
                                                                ChannelProducts& products) noexcept {
  sum_all(by, products);
}
const RoundKernels RoundKernels::avx2{outer_on_avx2, inner_on_avx2, sum_on_avx2};
const RoundKernels RoundKernels::avx512{outer_on_avx512, inner_on_avx512, sum_on_avx512};
#endif

}  // namespace

RoundImprint::RoundImprint(double side_m, double depth_m, std::optional<double> bonded_poisson)
    : side_m_(side_m),
      depth_m_(depth_m),
      parts_{parts_of(side_m, depth_m, kExactSides), parts_of(side_m, depth_m, kRoughSides)},
      sheet_(depth_m > 0 ? SquareMean::kMost * kMostNodes : 0, side_m, depth_m, bonded_poisson) {
  if (!(depth_m > 0)) return;  // never used
  u_.resize(SquareMean::kMost * kMostNodes);
  v_.resize(SquareMean::kMost * kMostNodes);
  functions_.resize(Function::used * (kMostNodes + kGhosts));
  table_.resize(kPerNode * kMostNodes);
  best_kernels<RoundKernels>();  // not first within a fit
}

std::size_t RoundImprint::memory_bytes() const noexcept {
  return sheet_.memory_bytes() + sizeof(double) * (2 * u_.size() + functions_.size() + table_.size());
}

bool RoundImprint::pays(std::size_t count, double reach_m, Sheet::Detail detail,
                        std::size_t sheet_points) const noexcept {
  if (!(depth_m_ > 0)) return false;
  const double nodes = reach_m / (step_depths(detail) * depth_m_) + 2 + kGhosts;
  if (!(nodes < static_cast<double>(kMostNodes))) return false;
  // Measured: a table's point takes as long as a sheet's, a taxel in it and one of two sheets a little
  // longer.
  constexpr double kTaxel = 1.2, kOfSheets = 1.5;
  const auto parts = static_cast<double>(parts_along(detail)), points = static_cast<double>(sheet_points);
  return 2 * static_cast<double>(mean_of(detail).points) * nodes <
         static_cast<double>(count) * (2 * points * points + kOfSheets - kTaxel * parts * parts);
}

void RoundImprint::tabulate(const RoundTrial& trial, Sheet::Detail detail, std::size_t nodes,
                            double part_m) noexcept {
  const SquareMean& mean = mean_of(detail);
  const double step_m = step_depths(detail) * depth_m_;
  for (std::size_t point = 0; point < mean.points; ++point) {
    for (std::size_t j = 0; j < nodes; ++j) {
      u_[point * nodes + j] = static_cast<double>(j) * step_m + part_m * mean.along[point];
      v_[point * nodes + j] = part_m * mean.across[point];
    }
  }
  const double k = std::cbrt(trial.gamma), a = trial.radius_m;
  const std::size_t stride = kMostNodes + kGhosts;
  std::fill(functions_.begin(), functions_.end(), 0.0);
  const Filling filling{.sheet = &sheet_,
                        .mean = &mean,
                        .functions = functions_.data(),
                        .table = table_.data(),
                        .stride = stride,
                        .nodes = nodes,
                        .wide_m = a,
                        .narrow_m = k * a,
                        .k = k};
  const std::span<const double> u(u_.data(), mean.points * nodes), v(v_.data(), mean.points * nodes);
  const RoundKernels& kernels = best_kernels<RoundKernels>();
  sheet_.evaluate({a, a, 0}, u, v, Sheet::Detail::centre);
  kernels.outer(filling);
  sheet_.evaluate({k * a, k * a, 0}, u, v, Sheet::Detail::centre);
  kernels.inner(filling);
}

void RoundImprint::linearise(const RoundTrial& trial, double reach_m, Sheet::Detail detail,
                             const RoundTask& task, ChannelProducts& products) noexcept {
  const std::size_t parts = parts_along(detail);
  const double part_m = side_m_ / static_cast<double>(parts), step_m = step_depths(detail) * depth_m_;
  const auto nodes =
      std::min(static_cast<std::size_t>(reach_m / step_m) + 2 + kGhosts, std::size_t{kMostNodes});
  tabulate(trial, detail, nodes, part_m);
  const double k = std::cbrt(trial.gamma), rest = 1 - trial.gamma;
  best_kernels<RoundKernels>().sum({.task = &task,
                                    .table = table_.data(),
                                    .x = trial.x_m,
                                    .y = trial.y_m,
                                    .per_step = 1 / step_m,
                                    .last = static_cast<double>(nodes - kGhosts - 1) - 1e-9,
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
