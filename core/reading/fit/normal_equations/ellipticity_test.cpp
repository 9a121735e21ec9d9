#include "core/reading/fit/normal_equations/ellipticity_test.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

using Sheet = contact::SubsurfaceSheet;

// Derivatives by log(a/b) as functions of the distance: of the dome O of the pressure, and of M, that of the
// shear, as in axisymmetric_normal_equations.cpp. nt, tn and rt go with the sine of twice the angle from the
// long axis, all others with its cosine. t: across the radius.
enum Function : std::uint8_t { o_nn, o_rn, o_tn, m_nr, m_nt, m_rr, m_rt, m_tt };
static_assert(m_tt + 1 == EllipticityTest::kFunctions);

// Distance of nodes over depth. What lies between is linear: shapes that are not exact cost a little of the
// test's power, and nothing else.
constexpr double kStepDepths = 0.3;

struct Scoring {
  const RoundTask* task;
  const double* table;
  double x, y, per_step, last;
  double p, q, c, s;
};
// Products of the columns of both components of the ellipse with each other and with the residuals.
struct Score {
  double along2 = 0, both = 0, across2 = 0, along = 0, across = 0;
};

struct Channels {
  double n, x, y;
};

[[gnu::always_inline]] inline void score(const Scoring& by, Score& out) noexcept {
  constexpr std::size_t kF = EllipticityTest::kFunctions;
  constexpr double kLeast = 1e-6;  // of a step: the direction at the centre is any
  const RoundTask& task = *by.task;
  const std::size_t count = task.count;
  const double *const px = task.x_m, *const py = task.y_m, *const left = task.residuals,
                      *const table = by.table;
  const double wn = task.per_normal, ws = task.per_shear, p = by.p, q = by.q;
  double along2 = 0, both = 0, across2 = 0, along = 0, across = 0;
#pragma omp simd reduction(+ : along2, both, across2, along, across)
  for (std::size_t i = 0; i < count; ++i) {
    const double x = px[i] - by.x, y = py[i] - by.y;
    const double r = std::max(std::sqrt(x * x + y * y), kLeast / by.per_step), ex = x / r, ey = y / r;
    const double place = std::min(r * by.per_step, by.last);
    const int node = static_cast<int>(place);
    const double part = place - node;
    const double* const at = table + static_cast<std::ptrdiff_t>(node) * static_cast<std::ptrdiff_t>(kF);
    const auto f = [&](Function which) __attribute__((always_inline)) {
      return at[which] + part * (at[which + kF] - at[which]);
    };
    const double er = q * (by.c * ex + by.s * ey), et = q * (by.s * ex - by.c * ey);  // of the pull
    // What goes with the cosine, and with the sine.
    const double n_cos = p * f(o_nn) + er * f(m_nr), n_sin = et * f(m_nt);
    const double r_cos = p * f(o_rn) + er * f(m_rr), r_sin = et * f(m_rt);
    const double t_cos = et * f(m_tt), t_sin = p * f(o_tn) + er * f(m_rt);
    const auto turned = [&](double cosine, double sine) __attribute__((always_inline)) {
      const double radial = cosine * r_cos + sine * r_sin, around = cosine * t_cos + sine * t_sin;
      return Channels{wn * (cosine * n_cos + sine * n_sin), ws * (radial * ex - around * ey),
                      ws * (radial * ey + around * ex)};
    };
    const double cosine = ex * ex - ey * ey, sine = 2 * ex * ey;
    const Channels one = turned(cosine, sine), two = turned(sine, -cosine);
    along2 += one.n * one.n + one.x * one.x + one.y * one.y;
    both += one.n * two.n + one.x * two.x + one.y * two.y;
    across2 += two.n * two.n + two.x * two.x + two.y * two.y;
    along += one.n * left[i] + one.x * left[count + i] + one.y * left[2 * count + i];
    across += two.n * left[i] + two.x * left[count + i] + two.y * left[2 * count + i];
  }
  out = {along2, both, across2, along, across};
}

// As in core/simd/inlined_loops.hpp.
struct EllipticityKernels {
  void (*score)(const Scoring&, Score&) noexcept;
  static const EllipticityKernels baseline, avx2, avx512;  // chosen by best_kernels
};
void score_on_baseline(const Scoring& by, Score& out) noexcept {
  score(by, out);
}
const EllipticityKernels EllipticityKernels::baseline{score_on_baseline};
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] void score_on_avx2(const Scoring& by, Score& out) noexcept {
  score(by, out);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void score_on_avx512(const Scoring& by, Score& out) noexcept {
  score(by, out);
}
const EllipticityKernels EllipticityKernels::avx2{score_on_avx2};
const EllipticityKernels EllipticityKernels::avx512{score_on_avx512};
#endif

}  // namespace

EllipticityTest::EllipticityTest(double depth_m, std::optional<double> bonded_poisson)
    : sheet_(depth_m > 0 ? 2 * kMostNodes : 0, 0, depth_m, bonded_poisson) {
  if (!(depth_m > 0)) return;  // never used
  u_.resize(2 * kMostNodes);
  v_.resize(2 * kMostNodes);
  table_.resize(kFunctions * kMostNodes);
  best_kernels<EllipticityKernels>();  // not first within a fit
}

std::size_t EllipticityTest::nodes_for(double reach_m) const noexcept {
  const double steps = reach_m / (kStepDepths * sheet_.depth_m());
  return steps < kMostNodes ? static_cast<std::size_t>(steps) + 2 : kMostNodes + 1;  // of a fit that ran away
}

// On a line along the long axis the sine is 0, between both axes the cosine.
void EllipticityTest::add_dome(double radius_m, double of_pressure, double of_shear,
                               std::size_t nodes) noexcept {
  constexpr double kRoot = 0.5 * std::numbers::sqrt2;
  constexpr double kApart = 1e-6;  // of the axes: a round dome's rows would have one axis only
  sheet_.evaluate({radius_m * (1 + kApart), radius_m, 0}, std::span(u_).first(2 * nodes),
                  std::span(v_).first(2 * nodes), Sheet::Detail::centre);
  const auto by_axes = [&](Sheet::Component component, std::size_t i) {
    return 0.5 * radius_m * (sheet_.row(Sheet::d_a, component)[i] - sheet_.row(Sheet::d_b, component)[i]);
  };
  for (std::size_t j = 0; j < nodes; ++j) {
    const std::size_t between = nodes + j;
    double* const to = table_.data() + j * kFunctions;
    to[o_nn] += of_pressure * by_axes(Sheet::nn, j);
    to[o_rn] += of_pressure * by_axes(Sheet::xn, j);
    to[o_tn] += of_pressure * kRoot * (by_axes(Sheet::yn, between) - by_axes(Sheet::xn, between));
    to[m_nr] += of_shear * by_axes(Sheet::nx, j);
    to[m_nt] += of_shear * kRoot * (by_axes(Sheet::ny, between) - by_axes(Sheet::nx, between));
    to[m_rr] += of_shear * by_axes(Sheet::xx, j);
    to[m_rt] += of_shear * 0.5 * (by_axes(Sheet::yy, between) - by_axes(Sheet::xx, between));
    to[m_tt] += of_shear * by_axes(Sheet::yy, j);
  }
}

// Without what other unknowns take up of the ellipse: on a whole disc it is little, as they go with the angle
// itself or not with it at all.
double EllipticityTest::sigmas2(const RoundTrial& trial, double reach_m, const RoundTask& task) noexcept {
  constexpr double kRoot = 0.5 * std::numbers::sqrt2;
  const std::size_t nodes = nodes_for(reach_m);
  const double step_m = kStepDepths * sheet_.depth_m(), k = std::cbrt(trial.gamma);
  for (std::size_t j = 0; j < nodes; ++j) {
    const double r = static_cast<double>(j) * step_m;
    u_[j] = r;
    v_[j] = 0;
    u_[nodes + j] = v_[nodes + j] = kRoot * r;
  }
  std::fill_n(table_.begin(), nodes * kFunctions, 0.0);
  add_dome(trial.radius_m, 1, 1, nodes);
  add_dome(k * trial.radius_m, 0, -k, nodes);
  Score found;
  best_kernels<EllipticityKernels>().score({.task = &task,
                                            .table = table_.data(),
                                            .x = trial.x_m,
                                            .y = trial.y_m,
                                            .per_step = 1 / step_m,
                                            .last = static_cast<double>(nodes - 1) - 1e-9,
                                            .p = trial.peak_pa,
                                            .q = trial.peak_pa * trial.load / (1 - trial.gamma),
                                            .c = std::cos(trial.direction_rad),
                                            .s = std::sin(trial.direction_rad)},
                                           found);
  const double determinant = found.along2 * found.across2 - found.both * found.both;
  return (found.across2 * found.along * found.along - 2 * found.both * found.along * found.across +
          found.along2 * found.across * found.across) /
         determinant;
}

}  // namespace slipd
