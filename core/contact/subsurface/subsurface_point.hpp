// What is sensed at one point under the surface, with its derivatives: the closed form that SubsurfaceSheet
// evaluates at many points (docs/theory.md §5.4). Written so that the compiler turns a loop over points into
// vector instructions: no branch, always inlined.
//
// The potential of a dome over an ellipse with the half axes a and b (A = a^2, B = b^2) is
//   psi = (a b/4) integral over s > l of (1 - x^2/(A+s) - y^2/(B+s) - z^2/s) ds/D(s),   D^2 = (A+s)(B+s) s,
// where l is the confocal coordinate: x^2/(A+l) + y^2/(B+l) + z^2/l = 1. The tractions at depth consist of
// its second derivatives, which are algebraic but for two elliptic integrals.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/contact/subsurface/dome.hpp"

namespace slipd::contact {

// The tractions sensed of a dome of unit height, t_i = sum T_ij f_j, of a surface traction along j.
// Symmetric.
struct SensedTensor {
  double nn = 0, nx = 0, ny = 0, xx = 0, xy = 0, yy = 0;
};

// The same where an object that presses is not sensed as shear as one that pulls is sensed as pressure, that
// is above a rigid base: nx and ny are the pressure of a pull along x and y, xn and yn the shear of pressing.
struct LayerTensor {
  double nn = 0, nx = 0, ny = 0, xx = 0, xy = 0, yy = 0, xn = 0, yn = 0;
};

// a t + b r.
[[gnu::always_inline]] inline LayerTensor combined(double a, const LayerTensor& t, double b,
                                                   const LayerTensor& r) noexcept {
  return {a * t.nn + b * r.nn, a * t.nx + b * r.nx, a * t.ny + b * r.ny, a * t.xx + b * r.xx,
          a * t.xy + b * r.xy, a * t.yy + b * r.yy, a * t.xn + b * r.xn, a * t.yn + b * r.yn};
}

namespace subsurface {

// The greatest root l of x^2/(A+l) + y^2/(B+l) + z^2/l = 1 for A = B. z > 0.
[[gnu::always_inline]] inline double round_confocal(double aa, double rr, double zz) noexcept {
  const double half = 0.5 * (rr + zz - aa);
  const double large = std::fabs(half) + std::sqrt(half * half + aa * zz);
  return half > 0 ? large : aa * zz / large;
}

// The same for any A and B. The root for the circle that has the ellipse's radius in the point's direction is
// above it, that for a circle of the greater axis below. 1/f - 1, f the left side, is concave: after one step
// of Newton's method all are from below, and none passes the root.
[[gnu::always_inline]] inline double confocal(double aa, double bb, double zz, double xx,
                                              double yy) noexcept {
  constexpr int kSteps = 5;
  constexpr double kTiny = 1e-300;
  const double rr = xx + yy;
  const double along = rr / std::max(xx / aa + yy / bb, kTiny);
  const double least = round_confocal(std::max(aa, bb), rr, zz);
  double l = round_confocal(std::clamp(along, std::min(aa, bb), std::max(aa, bb)), rr, zz);
#pragma GCC unroll 5
  for (int i = 0; i < kSteps; ++i) {
    const double pa = 1 / (aa + l), pb = 1 / (bb + l), pz = 1 / l;
    const double f = xx * pa + yy * pb + zz * pz;
    const double g = xx * pa * pa + yy * pb * pb + zz * pz * pz;
    l = std::max(least, l + (f * f - f) / g);
  }
  return l;
}

// The same to 1e-9 of its value, by three steps of Halley's method and with one reciprocal for the three
// terms.
[[gnu::always_inline]] inline double confocal_near(double aa, double bb, double zz, double xx,
                                                   double yy) noexcept {
  constexpr int kSteps = 3;
  constexpr double kTiny = 1e-300;
  const double rr = xx + yy;
  const double along = rr / std::max(xx / aa + yy / bb, kTiny);
  const double least = round_confocal(std::max(aa, bb), rr, zz);
  double l = round_confocal(std::clamp(along, std::min(aa, bb), std::max(aa, bb)), rr, zz);
#pragma GCC unroll 3
  for (int i = 0; i < kSteps; ++i) {
    const double al = aa + l, bl = bb + l, both = al * bl, over = 1 / (both * l);
    const double pa = bl * l * over, pb = al * l * over, pz = both * over;
    const double fx = xx * pa, fy = yy * pb, fz = zz * pz;
    const double gx = fx * pa, gy = fy * pb, gz = fz * pz;
    const double off = 1 - (fx + fy + fz), g = gx + gy + gz, h = gx * pa + gy * pb + gz * pz;
    l = std::max(least, l - off * g / (g * g + off * h));
  }
  return l;
}

// Carlson's R_D(x, y, z) and R_D(x, z, y) by duplication (Carlson 1979), x, y, z > 0.
struct Carlson {
  double of_z, of_y;
};
[[gnu::always_inline]] inline double carlson_rest(double x, double y, double z) noexcept {
  const double mean = (x + y + 3 * z) / 5, over = 1 / mean;
  const double dx = 1 - x * over, dy = 1 - y * over, dz = 1 - z * over;
  const double e2 = dx * dy - 6 * dz * dz, e3 = (3 * dx * dy - 8 * dz * dz) * dz,
               e4 = 3 * (dx * dy - dz * dz) * dz * dz, e5 = dx * dy * dz * dz * dz;
  const double series =
      1 - 3.0 / 14 * e2 + e3 / 6 + 9.0 / 88 * e2 * e2 - 3.0 / 22 * e4 - 9.0 / 52 * e2 * e3 + 3.0 / 26 * e5;
  return series * over * std::sqrt(over);
}
[[gnu::always_inline]] inline Carlson carlson_rd(double x, double y, double z) noexcept {
  constexpr int kSteps = 5;  // deviations fall fourfold each step, and the rest is of their sixth power
  double sum_z = 0, sum_y = 0, share = 1;
#pragma GCC unroll 5
  for (int i = 0; i < kSteps; ++i) {
    const double rx = std::sqrt(x), ry = std::sqrt(y), rz = std::sqrt(z);
    const double l = rx * (ry + rz) + ry * rz;
    sum_z += share / (rz * (z + l));
    sum_y += share / (ry * (y + l));
    share *= 0.25;
    x = 0.25 * (x + l);
    y = 0.25 * (y + l);
    z = 0.25 * (z + l);
  }
  return {3 * sum_z + share * carlson_rest(x, y, z), 3 * sum_y + share * carlson_rest(x, z, y)};
}

// Integrals of ds/((A+s) D), ds/((B+s) D) and ds/(s D) over s > l, and the derivatives of I_z - I_a and
// I_z - I_b by A and B; of a round dome those by A = B are in the first two.
struct Integrals {
  double za, zb;  // I_z - I_a, I_z - I_b
  double za_by_a, zb_by_a, za_by_b, zb_by_b;
};

[[gnu::always_inline]] inline Integrals round_integrals(double aa, double l, double pa, double pz,
                                                        double per_d) noexcept {
  const double a = std::sqrt(aa), m = std::sqrt(l), angle = angle_from_height(a, m) / a;
  const double za = (2 / m - 3 * angle + m * pa) / aa;
  const double by = (-1.5 * za + l * (pz - pa) * per_d) / aa;  // homogeneous of degree -3/2 in l and A
  return {za, za, by, by, 0, 0};
}

// I_a and I_b of one ellipse over l as cubics between nodes that are even in m/(m + b), with m = sqrt(l) and
// b the shorter half axis: to 1e-6 of their greatest value.
struct IntegralTable {
  static constexpr int kIntervals = 48;
  static constexpr std::size_t kPerInterval = 8;  // four coefficients of each
  const double* coefficient = nullptr;
  double shorter = 0, first = 0, per_step = 0;
};
struct AxisIntegrals {
  double a, b;
};
[[gnu::always_inline]] inline AxisIntegrals axis_integrals(double aa, double bb, double l) noexcept {
  const Carlson rd = carlson_rd(l, bb + l, aa + l);
  return {2.0 / 3 * rd.of_z, 2.0 / 3 * rd.of_y};
}
[[gnu::always_inline]] inline AxisIntegrals axis_integrals(const IntegralTable& of, double l) noexcept {
  const double m = std::sqrt(l), place = (m / (m + of.shorter) - of.first) * of.per_step;
  const double within = std::min(std::max(place, 0.0), IntegralTable::kIntervals - 1e-9);
  const int interval = static_cast<int>(within);
  const double t = within - interval;
  const double* const c = of.coefficient;
  const int i = static_cast<int>(IntegralTable::kPerInterval) * interval;
  return {((c[i + 3] * t + c[i + 2]) * t + c[i + 1]) * t + c[i],
          ((c[i + 7] * t + c[i + 6]) * t + c[i + 5]) * t + c[i + 4]};
}

[[gnu::always_inline]] inline Integrals elliptic_integrals(double aa, double bb, double l, double pa,
                                                           double pb, double per_d,
                                                           const AxisIntegrals& along) noexcept {
  const double ia = along.a, ib = along.b, iz = 2 * per_d - ia - ib;
  // -1/2 integral of ds/((A+s)(B+s) D); where A and B are near, by their middle.
  const double apart = aa - bb, middle = 0.5 * (aa + bb);
  const bool near = std::fabs(apart) < 1e-4 * middle;
  const double pm = 1 / (middle + l), im = 0.5 * (ia + ib);
  const double round = (-1.5 * im + l * pm * per_d) / (4 * middle);
  const double both = near ? round : 0.5 * (ia - ib) / (near ? 1.0 : apart);
  const double a_by_a = (-1.5 * ia + l * pa * per_d - bb * both) / aa,
               b_by_b = (-1.5 * ib + l * pb * per_d - aa * both) / bb;
  const double z_by_a = -0.5 * (iz - ia) / aa, z_by_b = -0.5 * (iz - ib) / bb;
  return {iz - ia, iz - ib, z_by_a - a_by_a, z_by_a - both, z_by_b - both, z_by_b - b_by_b};
}

// What all derivatives share.
struct Common {
  double a, b, aa, bb, z, l, pa, pb, pz, ex, ey, ez, g, per_d, w, jx, jy, c;
  double za_by_a, zb_by_a, za_by_b, zb_by_b;  // see Integrals
};

enum class Shape : unsigned char { round, elliptic, tabled };  // tabled: elliptic, integrals by a table

template <Shape kShape>
[[gnu::always_inline]] inline Common common(double a, double b, double z, double x, double y,
                                            const IntegralTable& table = {}) noexcept {
  constexpr bool kRound = kShape == Shape::round;
  Common at;
  at.a = a;
  at.b = b;
  at.aa = a * a;
  at.bb = b * b;
  at.z = z;
  if constexpr (kRound) {
    at.l = round_confocal(at.aa, x * x + y * y, z * z);
  } else if constexpr (kShape == Shape::tabled) {
    at.l = confocal_near(at.aa, at.bb, z * z, x * x, y * y);
  } else {
    at.l = confocal(at.aa, at.bb, z * z, x * x, y * y);
  }
  at.pa = 1 / (at.aa + at.l);
  at.pb = kRound ? at.pa : 1 / (at.bb + at.l);
  at.pz = 1 / at.l;
  at.ex = x * at.pa;
  at.ey = y * at.pb;
  at.ez = z * at.pz;
  at.g = at.ex * at.ex + at.ey * at.ey + at.ez * at.ez;
  at.per_d = std::sqrt(at.pa * at.pb * at.pz);
  at.w = z * a * b * at.per_d / at.g;
  at.c = 0.5 * z * a * b;
  Integrals in;
  if constexpr (kRound) {
    in = round_integrals(at.aa, at.l, at.pa, at.pz, at.per_d);
  } else if constexpr (kShape == Shape::tabled) {
    in = elliptic_integrals(at.aa, at.bb, at.l, at.pa, at.pb, at.per_d, axis_integrals(table, at.l));
  } else {
    in = elliptic_integrals(at.aa, at.bb, at.l, at.pa, at.pb, at.per_d, axis_integrals(at.aa, at.bb, at.l));
  }
  at.jx = at.c * in.za;
  at.jy = at.c * in.zb;
  at.za_by_a = in.za_by_a;
  at.zb_by_a = in.zb_by_a;
  at.za_by_b = in.za_by_b;
  at.zb_by_b = in.zb_by_b;
  return at;
}

[[gnu::always_inline]] inline SensedTensor value_of(const Common& at) noexcept {
  return {at.w * at.ez * at.ez,         at.w * at.ez * at.ex, at.w * at.ez * at.ey,
          at.w * at.ex * at.ex + at.jx, at.w * at.ex * at.ey, at.w * at.ey * at.ey + at.jy};
}

// The derivative along a change (dx, dy, da, db) of x, y, A and B. dza, dzb: the change of I_z - I_a and
// I_z - I_b that da and db cause.
[[gnu::always_inline]] inline SensedTensor slope_of(const Common& at, double dx, double dy, double da,
                                                    double db, double dza, double dzb) noexcept {
  const double dl = (2 * at.ex * dx + 2 * at.ey * dy - at.ex * at.ex * da - at.ey * at.ey * db) / at.g;
  const double dex = at.pa * (dx - at.ex * (da + dl)), dey = at.pb * (dy - at.ey * (db + dl)),
               dez = -at.ez * at.pz * dl;
  const double dc = 0.5 * (da / at.aa + db / at.bb);
  const double dw = dc - 2 * (at.ex * dex + at.ey * dey + at.ez * dez) / at.g -
                    0.5 * (at.pa * (da + dl) + at.pb * (db + dl) + at.pz * dl);
  const double djx = at.jx * dc + at.c * (dza - (at.pz - at.pa) * at.per_d * dl),
               djy = at.jy * dc + at.c * (dzb - (at.pz - at.pb) * at.per_d * dl);
  return {at.w * at.ez * (at.ez * dw + 2 * dez),
          at.w * (at.ez * at.ex * dw + at.ez * dex + dez * at.ex),
          at.w * (at.ez * at.ey * dw + at.ez * dey + dez * at.ey),
          at.w * at.ex * (at.ex * dw + 2 * dex) + djx,
          at.w * (at.ex * at.ey * dw + at.ex * dey + dex * at.ey),
          at.w * at.ey * (at.ey * dw + 2 * dey) + djy};
}

}  // namespace subsurface

// The value alone at (x, y) along the axes from the dome's centre, depth z > 0 below; any unit of length.
// Structs of many members would keep a loop scalar: derivatives are taken one by one.
template <subsurface::Shape kShape>
[[gnu::always_inline]] inline SensedTensor sensed_value(
    double a, double b, double z, double x, double y, const subsurface::IntegralTable& table = {}) noexcept {
  return subsurface::value_of(subsurface::common<kShape>(a, b, z, x, y, table));
}

}  // namespace slipd::contact
