#include "core/contact/subsurface/subsurface.hpp"

#include <algorithm>
#include <cmath>

#include "core/contact/subsurface/integral_table.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd::contact {
namespace {

// `count` of the points of a list; its rows are `stride` apart.
struct Points {
  const double *u, *v;
  double* rows;
  std::size_t stride, count;
};
// So many points' rows stay in the processor's nearest cache.
constexpr std::size_t kPointsTogether = 64;

// A dome, a point of each taxel's square and its weight.
struct DomePoint {
  double a, b, cosine, sine, depth, side;
  double u = 0, v = 0, weight = 0;
  subsurface::IntegralTable table = {};
};

// From the ellipse's axes to the sensor's.
[[gnu::always_inline]] inline SensedTensor turned(const SensedTensor& t, double c, double s) noexcept {
  const double across = 2 * c * s * t.xy;
  return {t.nn,
          c * t.nx - s * t.ny,
          s * t.nx + c * t.ny,
          c * c * t.xx + s * s * t.yy - across,
          c * s * (t.xx - t.yy) + (c * c - s * s) * t.xy,
          s * s * t.xx + c * c * t.yy + across};
}

[[gnu::always_inline]] inline SensedTensor mixed(double one, const SensedTensor& t, double two,
                                                 const SensedTensor& r) noexcept {
  return {one * t.nn + two * r.nn, one * t.nx + two * r.nx, one * t.ny + two * r.ny,
          one * t.xx + two * r.xx, one * t.xy + two * r.xy, one * t.yy + two * r.yy};
}

// By the log of the depth. What is sensed depends on ratios of lengths only: it stays where all of them grow
// alike, so that a greater depth is as all other lengths smaller (Euler's theorem of homogeneous functions).
[[gnu::always_inline]] inline SensedTensor by_depth(double u, const SensedTensor& d_u, double v,
                                                    const SensedTensor& d_v,
                                                    const SensedTensor& grown) noexcept {
  return mixed(-1, mixed(u, d_u, v, d_v), -1, grown);
}

// Of a dome that turns: its field turns with it, and so do its components.
[[gnu::always_inline]] inline SensedTensor by_angle(const SensedTensor& value, const SensedTensor& d_u,
                                                    const SensedTensor& d_v, double u, double v) noexcept {
  const SensedTensor moved = mixed(v, d_u, -u, d_v);
  return {moved.nn,
          moved.nx - value.ny,
          moved.ny + value.nx,
          moved.xx - 2 * value.xy,
          moved.xy + value.xx - value.yy,
          moved.yy + 2 * value.xy};
}

// kFirst: of a taxel's points, in place of what the row held.
template <bool kFirst>
[[gnu::always_inline]] inline void add(const SensedTensor& t, double weight, double* row,
                                       std::size_t stride) noexcept {
  const auto put = [](double& to, double value) __attribute__((always_inline)) {
    to = kFirst ? value : to + value;
  };
  put(row[0], weight * t.nn);
  put(row[stride], weight * t.nx);
  put(row[2 * stride], weight * t.ny);
  put(row[3 * stride], weight * t.xx);
  put(row[4 * stride], weight * t.xy);
  put(row[5 * stride], weight * t.yy);
}

using Sheet = SubsurfaceSheet;
using subsurface::fill_integrals;
using subsurface::IntegralTable;
using subsurface::Shape;

template <bool kFirst>
[[gnu::always_inline]] inline void round_slopes(const DomePoint& of, const Points& to) noexcept {
  const std::size_t n = Sheet::kHalfSpace * to.stride;
#pragma omp simd
  for (std::size_t i = 0; i < to.count; ++i) {
    const double u = to.u[i] + of.u, v = to.v[i] + of.v, a2 = 2 * of.a;
    const auto at = subsurface::common<Shape::round>(of.a, of.a, of.depth, u, v);
    const SensedTensor d_u = subsurface::slope_of(at, 1, 0, 0, 0, 0, 0),
                       d_v = subsurface::slope_of(at, 0, 1, 0, 0, 0, 0),
                       d_a = subsurface::slope_of(at, 0, 0, a2, a2, a2 * at.za_by_a, a2 * at.zb_by_a);
    double* const row = to.rows + i;
    add<kFirst>(subsurface::value_of(at), of.weight, row, to.stride);
    add<kFirst>(d_u, of.weight, row + Sheet::d_u * n, to.stride);
    add<kFirst>(d_v, of.weight, row + Sheet::d_v * n, to.stride);
    add<kFirst>(d_a, of.weight, row + Sheet::d_a * n, to.stride);
    add<kFirst>(by_depth(u, d_u, v, d_v, mixed(of.a, d_a, 0, d_a)), of.weight, row + Sheet::d_depth * n,
                to.stride);
  }
}

template <bool kFirst>
[[gnu::always_inline]] inline void round_values(const DomePoint& of, const Points& to) noexcept {
#pragma omp simd
  for (std::size_t i = 0; i < to.count; ++i)
    add<kFirst>(sensed_value<Shape::round>(of.a, of.a, of.depth, to.u[i] + of.u, to.v[i] + of.v), of.weight,
                to.rows + i, to.stride);
}

template <bool kFirst>
[[gnu::always_inline]] inline void elliptic_slopes(const DomePoint& of, const Points& to) noexcept {
  const std::size_t n = Sheet::kHalfSpace * to.stride;
  const double c = of.cosine, s = of.sine;
#pragma omp simd
  for (std::size_t i = 0; i < to.count; ++i) {
    const double u = to.u[i] + of.u, v = to.v[i] + of.v, a2 = 2 * of.a, b2 = 2 * of.b;
    const auto at =
        subsurface::common<Shape::tabled>(of.a, of.b, of.depth, c * u + s * v, c * v - s * u, of.table);
    const SensedTensor value = turned(subsurface::value_of(at), c, s),
                       d_u = turned(subsurface::slope_of(at, c, -s, 0, 0, 0, 0), c, s),
                       d_v = turned(subsurface::slope_of(at, s, c, 0, 0, 0, 0), c, s),
                       d_a = turned(subsurface::slope_of(at, 0, 0, a2, 0, a2 * at.za_by_a, a2 * at.zb_by_a),
                                    c, s),
                       d_b = turned(subsurface::slope_of(at, 0, 0, 0, b2, b2 * at.za_by_b, b2 * at.zb_by_b),
                                    c, s);
    double* const row = to.rows + i;
    add<kFirst>(value, of.weight, row, to.stride);
    add<kFirst>(d_u, of.weight, row + Sheet::d_u * n, to.stride);
    add<kFirst>(d_v, of.weight, row + Sheet::d_v * n, to.stride);
    add<kFirst>(d_a, of.weight, row + Sheet::d_a * n, to.stride);
    add<kFirst>(by_depth(u, d_u, v, d_v, mixed(of.a, d_a, of.b, d_b)), of.weight, row + Sheet::d_depth * n,
                to.stride);
    add<kFirst>(d_b, of.weight, row + Sheet::d_b * n, to.stride);
    add<kFirst>(by_angle(value, d_u, d_v, u, v), of.weight, row + Sheet::d_angle * n, to.stride);
  }
}

template <bool kFirst>
[[gnu::always_inline]] inline void elliptic_values(const DomePoint& of, const Points& to) noexcept {
  const double c = of.cosine, s = of.sine;
#pragma omp simd
  for (std::size_t i = 0; i < to.count; ++i) {
    const double u = to.u[i] + of.u, v = to.v[i] + of.v;
    add<kFirst>(
        turned(sensed_value<Shape::tabled>(of.a, of.b, of.depth, c * u + s * v, c * v - s * u, of.table), c,
               s),
        of.weight, to.rows + i, to.stride);
  }
}

// The dome itself along a line through each taxel, parallel to x: 1 - alpha u^2 - 2 beta u v - gamma v^2 is a
// circle's along the line, whose integrals are elementary.
struct Quadratic {
  double alpha, beta, gamma;
};
struct Line {
  double mean, d_u, d_v, d_alpha, d_beta, d_gamma;
};
[[gnu::always_inline]] inline Quadratic quadratic_of(const DomePoint& of) noexcept {
  const double c = of.cosine, s = of.sine, aa = 1 / (of.a * of.a), bb = 1 / (of.b * of.b);
  return {c * c * aa + s * s * bb, c * s * (aa - bb), s * s * aa + c * c * bb};
}
[[gnu::always_inline]] inline Line line_of(const Quadratic& q, double u, double v, double side) noexcept {
  const double off = q.beta * v / q.alpha, root = std::sqrt(q.alpha),
               rest = q.gamma - q.beta * q.beta / q.alpha;
  const double rr = std::max(0.0, 1 - rest * v * v) / q.alpha, r = std::sqrt(rr);
  const double to = std::clamp(u + side / 2 + off, -r, r), from = std::clamp(u - side / 2 + off, -r, r);
  const double w_to = std::sqrt(std::max(0.0, rr - to * to)),
               w_from = std::sqrt(std::max(0.0, rr - from * from));
  const double angle = angle_from_height(to, w_to) - angle_from_height(from, w_from);
  const double over = 1 / (root * side), t0 = angle * over, t1 = (w_from - w_to) * over,
               t2 = 0.5 * (rr * angle - to * w_to + from * w_from) * over;
  const double u0 = t0, u1 = t1 - off * t0, u2 = t2 - 2 * off * t1 + off * off * t0;
  return {q.alpha * (rr * t0 - t2),
          root * (w_to - w_from) / side,
          -(q.beta * u1 + q.gamma * v * u0),
          -0.5 * u2,
          -v * u1,
          -0.5 * v * v * u0};
}

[[gnu::always_inline]] inline void surface_slopes(const DomePoint& of, const Points& to) noexcept {
  const std::size_t n = to.stride;
  const Quadratic q = quadratic_of(of);
  const double c = of.cosine, s = of.sine, apart = 1 / (of.a * of.a) - 1 / (of.b * of.b);
  const double by_a = -2 / (of.a * of.a * of.a), by_b = -2 / (of.b * of.b * of.b);
#pragma omp simd
  for (std::size_t i = 0; i < to.count; ++i) {
    const Line line = line_of(q, to.u[i], to.v[i] + of.v, of.side);
    double* const row = to.rows + i;
    *(row) += of.weight * line.mean;
    *(row + Sheet::d_u * n) += of.weight * line.d_u;
    *(row + Sheet::d_v * n) += of.weight * line.d_v;
    *(row + Sheet::d_a * n) +=
        of.weight * by_a * (c * c * line.d_alpha + c * s * line.d_beta + s * s * line.d_gamma);
    *(row + Sheet::d_b * n) +=
        of.weight * by_b * (s * s * line.d_alpha - c * s * line.d_beta + c * c * line.d_gamma);
    *(row + Sheet::d_angle * n) +=
        of.weight * (2 * q.beta * (line.d_gamma - line.d_alpha) + (c * c - s * s) * apart * line.d_beta);
  }
}

[[gnu::always_inline]] inline void surface_values(const DomePoint& of, const Points& to) noexcept {
  const Quadratic q = quadratic_of(of);
#pragma omp simd
  for (std::size_t i = 0; i < to.count; ++i)
    to.rows[i] += of.weight * line_of(q, to.u[i], to.v[i] + of.v, of.side).mean;
}

// As in core/simd/inlined_loops.hpp.
template <auto kLoop>
void sensed_on_baseline(const DomePoint& of, const Points& to) noexcept {
  kLoop(of, to);
}
void integrals_on_baseline(double aa, double bb, double shorter, double first, double per_step,
                           double* to) noexcept {
  fill_integrals(aa, bb, shorter, first, per_step, to);
}
#if defined(__x86_64__)
template <auto kLoop>
[[gnu::target("avx2,fma")]] void sensed_on_avx2(const DomePoint& of, const Points& to) noexcept {
  kLoop(of, to);
}
template <auto kLoop>
[[gnu::target("avx512f,avx512vl,avx512dq")]] void sensed_on_avx512(const DomePoint& of,
                                                                   const Points& to) noexcept {
  kLoop(of, to);
}
[[gnu::target("avx2,fma")]] void integrals_on_avx2(double aa, double bb, double shorter, double first,
                                                   double per_step, double* to) noexcept {
  fill_integrals(aa, bb, shorter, first, per_step, to);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void integrals_on_avx512(double aa, double bb, double shorter,
                                                                      double first, double per_step,
                                                                      double* to) noexcept {
  fill_integrals(aa, bb, shorter, first, per_step, to);
}
#endif

struct SubsurfaceKernels {
  using Kernel = void (*)(const DomePoint&, const Points&) noexcept;
  // For a taxel's first point, and for the others.
  struct Pair {
    Kernel first, other;
  };
  void (*integrals)(double, double, double, double, double, double*) noexcept;
  Pair round, round_value, elliptic, elliptic_value;
  Kernel surface, surface_value;
  static const SubsurfaceKernels baseline, avx2, avx512;  // chosen by best_kernels
};
const SubsurfaceKernels SubsurfaceKernels::baseline{
    integrals_on_baseline,
    {sensed_on_baseline<round_slopes<true>>, sensed_on_baseline<round_slopes<false>>},
    {sensed_on_baseline<round_values<true>>, sensed_on_baseline<round_values<false>>},
    {sensed_on_baseline<elliptic_slopes<true>>, sensed_on_baseline<elliptic_slopes<false>>},
    {sensed_on_baseline<elliptic_values<true>>, sensed_on_baseline<elliptic_values<false>>},
    sensed_on_baseline<surface_slopes>,
    sensed_on_baseline<surface_values>};
#if defined(__x86_64__)
const SubsurfaceKernels SubsurfaceKernels::avx2{
    integrals_on_avx2,
    {sensed_on_avx2<round_slopes<true>>, sensed_on_avx2<round_slopes<false>>},
    {sensed_on_avx2<round_values<true>>, sensed_on_avx2<round_values<false>>},
    {sensed_on_avx2<elliptic_slopes<true>>, sensed_on_avx2<elliptic_slopes<false>>},
    {sensed_on_avx2<elliptic_values<true>>, sensed_on_avx2<elliptic_values<false>>},
    sensed_on_avx2<surface_slopes>,
    sensed_on_avx2<surface_values>};
const SubsurfaceKernels SubsurfaceKernels::avx512{
    integrals_on_avx512,
    {sensed_on_avx512<round_slopes<true>>, sensed_on_avx512<round_slopes<false>>},
    {sensed_on_avx512<round_values<true>>, sensed_on_avx512<round_values<false>>},
    {sensed_on_avx512<elliptic_slopes<true>>, sensed_on_avx512<elliptic_slopes<false>>},
    {sensed_on_avx512<elliptic_values<true>>, sensed_on_avx512<elliptic_values<false>>},
    sensed_on_avx512<surface_slopes>,
    sensed_on_avx512<surface_values>};
#endif

// At the depth of `point`, by all points of each taxel. integrals: room for an IntegralTable.
void fill_half_space(DomePoint point, const Points& to, bool round, bool slopes, const SideRule& rule,
                     double* integrals) noexcept {
  const SubsurfaceKernels& kernels = best_kernels<SubsurfaceKernels>();
  const SubsurfaceKernels::Pair& kernel = round ? (slopes ? kernels.round : kernels.round_value)
                                                : (slopes ? kernels.elliptic : kernels.elliptic_value);
  if (!round) {
    point.table = {.coefficient = integrals, .shorter = std::min(point.a, point.b)};
    point.table.first = point.depth / (point.depth + point.table.shorter);  // l is at least d^2
    point.table.per_step = IntegralTable::kIntervals / (1 - point.table.first);
    kernels.integrals(point.a * point.a, point.b * point.b, point.table.shorter, point.table.first,
                      point.table.per_step, integrals);
  }
  for (std::size_t first = 0; first < to.count; first += kPointsTogether) {
    const Points part{to.u + first, to.v + first, to.rows + first, to.stride,
                      std::min(kPointsTogether, to.count - first)};
    for (std::size_t i = 0; i < rule.at.size(); ++i) {
      for (std::size_t j = 0; j < rule.at.size(); ++j) {
        point.u = rule.at[i];
        point.v = rule.at[j];
        point.weight = rule.weight[i] * rule.weight[j];
        (i + j == 0 ? kernel.first : kernel.other)(point, part);
      }
    }
  }
}

// What reaches a rigid base is as smooth as at less depth in a half space.
constexpr double kSharper = 1.25;

// By Detail; smooth_m: the depth in a half space at which stresses are as smooth.
std::array<SideRule, 3> rules_of(double side_m, double smooth_m) {
  return {exact_side_rule(side_m, smooth_m), rough_side_rule(side_m, smooth_m), SideRule{{0.0}, {1.0}}};
}

}  // namespace

SensedTensor sensed_of_dome(const Ellipse& ellipse, double depth_m, double x_m, double y_m) noexcept {
  const double c = std::cos(ellipse.angle_rad), s = std::sin(ellipse.angle_rad);
  const double x = c * x_m + s * y_m, y = c * y_m - s * x_m, a = ellipse.a_m, b = ellipse.b_m;
  if (!(depth_m > 0)) {
    const double height = std::sqrt(std::max(0.0, 1 - x * x / (a * a) - y * y / (b * b)));
    return {.nn = height, .xx = height, .yy = height};
  }
  return turned(ellipse.round() ? sensed_value<Shape::round>(a, a, depth_m, x, y)
                                : sensed_value<Shape::elliptic>(a, b, depth_m, x, y),
                c, s);
}

SubsurfaceSheet::SubsurfaceSheet(std::size_t most, double side_m, double depth_m,
                                 std::optional<double> bonded_poisson)
    : side_m_(side_m),
      depth_m_(depth_m),
      rules_(rules_of(side_m, bonded_poisson ? depth_m / kSharper : depth_m)),
      zeros_(depth_m > 0 ? 0 : most) {
  const bool skin = depth_m > 0, bonded = skin && bonded_poisson;
  if (skin) integrals_.resize(IntegralTable::kIntervals * IntegralTable::kPerInterval);
  if (bonded) {
    const auto images = layer_images(*bonded_poisson);
    images_.assign(images.begin(), images.end());
    image_rows_.resize(most * kRows * kHalfSpace);
  }
  rows_.resize(most * kRows * (skin ? components() : 1));
  best_kernels<SubsurfaceKernels>();  // not first within a fit
}

void SubsurfaceSheet::run(const Ellipse& dome, std::span<const double> u, std::span<const double> v,
                          bool slopes, const SideRule& rule) noexcept {
  count_ = u.size();
  const bool surface = !(depth_m_ > 0);
  const std::size_t rows = !slopes                    ? std::size_t{d_u}
                           : dome.round() && !surface ? std::size_t{d_b}
                                                      : std::size_t{kRows};
  if (surface || !images_.empty())
    std::fill_n(rows_.begin(), rows * (surface ? 1 : components()) * count_, 0.0);
  DomePoint point{.a = dome.a_m,
                  .b = dome.b_m,
                  .cosine = std::cos(dome.angle_rad),
                  .sine = std::sin(dome.angle_rad),
                  .depth = depth_m_,
                  .side = side_m_};
  if (surface) {
    const SubsurfaceKernels& kernels = best_kernels<SubsurfaceKernels>();
    const Points to{u.data(), v.data(), rows_.data(), count_, count_};
    for (std::size_t j = 0; j < rule.at.size(); ++j) {
      point.v = rule.at[j];
      point.weight = rule.weight[j];
      (slopes ? kernels.surface : kernels.surface_value)(point, to);
    }
    return;
  }
  const auto fill = [&](double* to) {
    fill_half_space(point, {u.data(), v.data(), to, count_, count_}, dome.round(), slopes, rule,
                    integrals_.data());
  };
  if (images_.empty()) return fill(rows_.data());
  for (const LayerImage& image : images_) {
    point.depth = image.depth * depth_m_;
    fill(image_rows_.data());
    for (std::size_t row = 0; row < rows; ++row)
      add_image(image, image_rows_.data() + row * kHalfSpace * count_,
                rows_.data() + row * kComponents * count_, count_);
  }
}

void SubsurfaceSheet::evaluate(const Ellipse& dome, std::span<const double> u, std::span<const double> v,
                               Detail detail) noexcept {
  run(dome, u, v, true, rule_of(detail));
}

void SubsurfaceSheet::evaluate_values(const Ellipse& dome, std::span<const double> u,
                                      std::span<const double> v, Detail detail) noexcept {
  run(dome, u, v, false, rule_of(detail));
}

}  // namespace slipd::contact
