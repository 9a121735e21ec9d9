#include "core/contact/limit_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/contact/averages.hpp"
#include "core/numeric/iteration.hpp"
#include "core/numeric/norm.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd::contact {
namespace {

// The mean distance from the centre over its root mean square: 3 pi/16 over sqrt(2/5) for Hertz; 0.94 for an
// even pressure. It only scales the search, which starts on the ellipsoid of this T_max.
constexpr double kMeanOverRms = 0.931;

// A rigid velocity in units of the pull's speed: along the pull, across it and w times the unit of length.
struct Motion {
  float along_x, along_y, spin;        // at the present point
  float slope_x, slope_y, slope_spin;  // of it by the first unknown
  float across_x, across_y;            // of it by the second unknown
};

// The dissipation sum p |v + w x r| and its derivatives by both unknowns.
struct Dissipation {
  float value = 0, d_1 = 0, d_2 = 0, d_11 = 0, d_12 = 0, d_22 = 0;
};

struct Cells {
  const float *x, *y, *normal;
  float per_length, spread;  // 1/unit of length; a cell's second moment along an axis in that unit
  std::size_t count;
};

using Kernel = Dissipation (*)(const Cells&, const Motion&) noexcept;

// Everything is a local of its own: the compiler vectorises no loop that reads through references.
[[gnu::always_inline]] inline Dissipation dissipation(const Cells& at, const Motion& motion) noexcept {
  constexpr float kTiny = 1e-30F;  // keeps quotients finite at the centre of the motion
  const float *const xs = at.x, *const ys = at.y, *const normal = at.normal;
  const float scale = at.per_length, spread = at.spread;
  const std::size_t count = at.count;
  const float along_x = motion.along_x, along_y = motion.along_y, spin = motion.spin;
  const float slope_x = motion.slope_x, slope_y = motion.slope_y, slope_spin = motion.slope_spin;
  const float across_x = motion.across_x, across_y = motion.across_y;
  const float still = spin * spin * spread + kTiny, still_1 = spin * slope_spin * spread,
              still_11 = slope_spin * slope_spin * spread;
  float value = 0, d_1 = 0, d_2 = 0, d_11 = 0, d_12 = 0, d_22 = 0;
#pragma omp simd reduction(+ : value, d_1, d_2, d_11, d_12, d_22)
  for (std::size_t i = 0; i < count; ++i) {
    const float x = xs[i] * scale, y = ys[i] * scale, p = normal[i];
    const float ux = along_x - spin * y, uy = along_y + spin * x;
    const float ux_1 = slope_x - slope_spin * y, uy_1 = slope_y + slope_spin * x;
    const float speed = std::sqrt(ux * ux + uy * uy + still), over = 1 / speed, share = p * over;
    const float by_1 = (ux * ux_1 + uy * uy_1 + still_1) * over,
                by_2 = (ux * across_x + uy * across_y) * over;
    value += p * speed;
    d_1 += p * by_1;
    d_2 += p * by_2;
    d_11 += share * (ux_1 * ux_1 + uy_1 * uy_1 + still_11 - by_1 * by_1);
    d_12 += share * (ux_1 * across_x + uy_1 * across_y - by_1 * by_2);
    d_22 += share * (1 - by_2 * by_2);
  }
  return {value, d_1, d_2, d_11, d_12, d_22};
}

Dissipation on_baseline(const Cells& at, const Motion& motion) noexcept {
  return dissipation(at, motion);
}
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] Dissipation on_avx2(const Cells& at, const Motion& motion) noexcept {
  return dissipation(at, motion);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] Dissipation on_avx512(const Cells& at,
                                                                   const Motion& motion) noexcept {
  return dissipation(at, motion);
}
#endif

struct DissipationKernels {
  Kernel dissipation;
  static const DissipationKernels baseline, avx2, avx512;  // chosen by best_kernels
};
const DissipationKernels DissipationKernels::baseline{on_baseline};
#if defined(__x86_64__)
const DissipationKernels DissipationKernels::avx2{on_avx2};
const DissipationKernels DissipationKernels::avx512{on_avx512};
#endif

// The search. With the load as a unit vector (cosine, sine) of Q and of T over the unit of length, all
// velocities that do one unit of work are (cosine - b sine, c, sine + b cosine): along the pull, across it,
// and the spin. The dissipation is convex in b and c, and on an ellipsoid its least value is at 0.
class Search {
 public:
  Search(const Cells& cells, double pull_x, double pull_y, double cosine, double sine)
      : cells_(cells), pull_x_(pull_x), pull_y_(pull_y), cosine_(cosine), sine_(sine) {}

  Dissipation at(double b, double c) const noexcept {
    const double along = cosine_ - b * sine_;
    const Motion motion{.along_x = static_cast<float>(along * pull_x_ - c * pull_y_),
                        .along_y = static_cast<float>(along * pull_y_ + c * pull_x_),
                        .spin = static_cast<float>(sine_ + b * cosine_),
                        .slope_x = static_cast<float>(-sine_ * pull_x_),
                        .slope_y = static_cast<float>(-sine_ * pull_y_),
                        .slope_spin = static_cast<float>(cosine_),
                        .across_x = static_cast<float>(-pull_y_),
                        .across_y = static_cast<float>(pull_x_)};
    return best_kernels<DissipationKernels>().dissipation(cells_, motion);
  }

  // The least dissipation, and b there.
  void run() noexcept {
    constexpr int kMostHalvings = 8;
    Dissipation now = at(0, 0);
    for (int step = 0; step < kMostSteps; ++step) {
      const double d_1 = static_cast<double>(now.d_1), d_2 = static_cast<double>(now.d_2);
      double d_11 = static_cast<double>(now.d_11), d_22 = static_cast<double>(now.d_22);
      const double d_12 = static_cast<double>(now.d_12);
      // Noise in the forces can make it other than convex: then down the slope.
      double det = d_11 * d_22 - d_12 * d_12, cross = d_12;
      if (!(d_11 > 0) || !(d_22 > 0) || !(det > 0)) {
        d_11 = d_22 = static_cast<double>(now.value);
        cross = 0;
        det = d_11 * d_22;
      }
      const double to_1 = -(d_22 * d_1 - cross * d_2) / det, to_2 = -(d_11 * d_2 - cross * d_1) / det;
      const double gain = -(d_1 * to_1 + d_2 * to_2);
      // Beyond, single precision does not tell a gain.
      if (!(gain > static_cast<double>(std::numeric_limits<float>::epsilon() * now.value))) break;
      double part = 1;
      Dissipation next = at(b_ + to_1, c_ + to_2);
      for (int i = 0; i < kMostHalvings && !(next.value < now.value); ++i) {
        part /= 2;
        next = at(b_ + part * to_1, c_ + part * to_2);
      }
      if (!(next.value < now.value)) break;
      b_ += part * to_1;
      c_ += part * to_2;
      now = next;
    }
    least_ = static_cast<double>(now.value);
  }

  double least() const noexcept { return least_; }
  double along() const noexcept { return cosine_ - b_ * sine_; }
  double spin() const noexcept { return sine_ + b_ * cosine_; }

 private:
  Cells cells_;
  double pull_x_, pull_y_, cosine_, sine_;
  double b_ = 0, c_ = 0, least_ = 0;
};

}  // namespace

void LimitSurface::clear(double side_m) noexcept {
  size_ = 0;
  side_m_ = side_m;
  normal_n_ = squares_n_m2_ = 0;
}

void LimitSurface::add(double x_m, double y_m, double normal_n) noexcept {
  if (size_ == kMost) return;
  x_m_[size_] = static_cast<float>(x_m);
  y_m_[size_] = static_cast<float>(y_m);
  normal_each_n_[size_] = static_cast<float>(normal_n);
  ++size_;
  normal_n_ += normal_n;
  squares_n_m2_ += normal_n * (x_m * x_m + y_m * y_m + side_m_ * side_m_ / 6);
}

LeastFriction LimitSurface::least_friction(double shear_x_n, double shear_y_n,
                                           double torque_nm) const noexcept {
  const double shear_n = norm(shear_x_n, shear_y_n);
  if (!(normal_n_ > 0) || !(squares_n_m2_ > 0)) return {};
  const double unit_m = kMeanOverRms * std::sqrt(squares_n_m2_ / normal_n_);
  const double turn_n = torque_nm / unit_m, load_n = norm(shear_n, turn_n);
  if (!(load_n > 0)) return {};
  const double pull_x = shear_n > 0 ? shear_x_n / shear_n : 1, pull_y = shear_n > 0 ? shear_y_n / shear_n : 0;
  const Cells cells{.x = x_m_.data(),
                    .y = y_m_.data(),
                    .normal = normal_each_n_.data(),
                    .per_length = static_cast<float>(1 / unit_m),
                    .spread = static_cast<float>(side_m_ * side_m_ / (12 * unit_m * unit_m)),
                    .count = size_};
  Search search(cells, pull_x, pull_y, shear_n / load_n, turn_n / load_n);
  search.run();
  if (!(search.least() > 0)) return {};
  return {.ratio = load_n / search.least(),
          .per_shear_n = search.along() / search.least(),
          .per_torque_nm = std::copysign(1.0, torque_nm) * search.spin() / (search.least() * unit_m)};
}

LimitSurface unit_hertz_surface() {
  constexpr int kAcross = 14, kParts = 6;  // cells across the disc, parts of a cell along each side
  constexpr double kSide = 2.0 / kAcross, kPart = kSide / kParts;
  // The integral of sqrt(1 - r^2) over the disc.
  constexpr double kVolume = 2 * std::numbers::pi / 3;
  LimitSurface surface;
  surface.clear(kSide);
  for (int cell = 0; cell < kAcross * kAcross; ++cell) {
    const int column = cell % kAcross, row = cell / kAcross;
    double normal = 0, by_x = 0, by_y = 0;
    for (int part = 0; part < kParts * kParts; ++part) {
      const int part_column = part % kParts, part_row = part / kParts;
      const double x = column * kSide + (part_column + 0.5) * kPart - 1;
      const double y = row * kSide + (part_row + 0.5) * kPart - 1;
      const double force = disc_average_exact(1, x, y, kPart) * kPart * kPart / kVolume;
      normal += force;
      by_x += force * x;
      by_y += force * y;
    }
    if (normal > 0) surface.add(by_x / normal, by_y / normal, normal);
  }
  return surface;
}

}  // namespace slipd::contact
