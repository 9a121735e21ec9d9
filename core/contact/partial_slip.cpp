#include "core/contact/partial_slip.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numeric/iteration.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd::contact {
namespace {

constexpr std::size_t kSide = PartialSlip::kAcross;
constexpr double kMiddle = (static_cast<double>(kSide) - 1) / 2;

double column_of(std::size_t cell) noexcept {
  return static_cast<double>(cell % kSide) - kMiddle;
}
double row_of(std::size_t cell) noexcept {
  const std::size_t row = cell / kSide;
  return static_cast<double>(row) - kMiddle;
}

// The integral of 1/r over the rectangle between (0, 0) and (u, v), odd in both.
double inverse_distance_over_rectangle(double u, double v) noexcept {
  if (u == 0 || v == 0) return 0;
  return u * std::asinh(v / std::fabs(u)) + v * std::asinh(u / std::fabs(v));
}

// The mean of 1/r over the unit square about (u, v).
double inverse_distance(double u, double v) noexcept {
  const auto at = inverse_distance_over_rectangle;
  return at(u + 0.5, v + 0.5) - at(u - 0.5, v + 0.5) - at(u + 0.5, v - 0.5) + at(u - 0.5, v - 0.5);
}

// How far a unit force on one cell moves another, by their distance in rows and columns; the unit is that of
// cells and does not count.
struct Compliance {
  static constexpr std::size_t kWidth = 2 * kSide;
  // Column kSide - 1 is the distance 0.
  alignas(64) std::array<std::array<float, kWidth>, kSide> rows{};

  Compliance() noexcept {
    for (std::size_t row = 0; row < kSide; ++row) {
      for (std::size_t i = 0; i + 1 < kWidth; ++i) {
        const double column = static_cast<double>(i) - static_cast<double>(kSide - 1);
        rows[row][i] = static_cast<float>(inverse_distance(column, static_cast<double>(row)));
      }
    }
  }
};

struct Forces {
  const float *x, *y;  // kCells values
  float *out_x, *out_y;
  std::size_t first_row, end_row;  // of the cells that are not 0, and of those wanted
};

// out = A in, both directions at once.
[[gnu::always_inline]] inline void give(const Compliance& compliance, const Forces& forces) noexcept {
  for (std::size_t row = forces.first_row; row < forces.end_row; ++row) {
    float sum_x[kSide] = {}, sum_y[kSide] = {};
    for (std::size_t from = forces.first_row; from < forces.end_row; ++from) {
      const float* const kernel = compliance.rows[row > from ? row - from : from - row].data();
      for (std::size_t column = 0; column < kSide; ++column) {
        const float x = forces.x[from * kSide + column], y = forces.y[from * kSide + column];
        if (x == 0 && y == 0) continue;
        const float* const near = kernel + (kSide - 1 - column);
#pragma omp simd
        for (std::size_t i = 0; i < kSide; ++i) {
          sum_x[i] += near[i] * x;
          sum_y[i] += near[i] * y;
        }
      }
    }
    for (std::size_t i = 0; i < kSide; ++i) {
      forces.out_x[row * kSide + i] = sum_x[i];
      forces.out_y[row * kSide + i] = sum_y[i];
    }
  }
}

// The dual of the projection at one motion: value to be made least, the sums of what is carried, curvature.
struct Dual {
  double value = 0, x = 0, y = 0, turn = 0;
  double xx = 0, yy = 0, tt = 0, xy = 0, xt = 0, yt = 0;
};

struct Tractions {
  const float *x, *y, *limit;  // kCells values
  std::size_t first_row, end_row;
  double along_x, along_y, spin;  // the rigid motion
};

// Each cell moved by the motion and cut to its limit. Cells without friction carry nothing.
[[gnu::always_inline]] inline Dual dual(const Tractions& at) noexcept {
  const float *const dx = at.x, *const dy = at.y, *const limit = at.limit;
  const double along_x = at.along_x, along_y = at.along_y, spin = at.spin;
  double value = 0, x = 0, y = 0, turn = 0, xx = 0, yy = 0, tt = 0, xy = 0, xt = 0, yt = 0;
  for (std::size_t row = at.first_row; row < at.end_row; ++row) {
    const double v = static_cast<double>(row) - kMiddle;
#pragma omp simd reduction(+ : value, x, y, turn, xx, yy, tt, xy, xt, yt)
    for (std::size_t column = 0; column < kSide; ++column) {
      constexpr double kTiny = 1e-300;  // keeps quotients finite where nothing is carried
      const std::size_t cell = row * kSide + column;
      const auto most = static_cast<double>(limit[cell]);
      const double u = static_cast<double>(static_cast<int>(column)) - kMiddle;
      const double qx = static_cast<double>(dx[cell]) + along_x - spin * v;
      const double qy = static_cast<double>(dy[cell]) + along_y + spin * u;
      const double square = qx * qx + qy * qy + kTiny, size = std::sqrt(square);
      // What it keeps, and the curvature: 1 in all directions, or part/size across q.
      const bool slips = size > most;
      const double cut = most / size, part = slips ? cut : 1.0, across = slips ? cut / square : 0.0;
      const double kept = slips ? most * (size - 0.5 * most) : 0.5 * square;
      const double turned = u * qy - v * qx;
      value += kept;
      x += part * qx;
      y += part * qy;
      turn += part * turned;
      xx += part - across * qx * qx;
      yy += part - across * qy * qy;
      xy -= across * qx * qy;
      xt -= part * v + across * qx * turned;
      yt += part * u - across * qy * turned;
      tt += part * (u * u + v * v) - across * turned * turned;
    }
  }
  return {value, x, y, turn, xx, yy, tt, xy, xt, yt};
}

void give_on_baseline(const Compliance& compliance, const Forces& forces) noexcept {
  give(compliance, forces);
}
Dual dual_on_baseline(const Tractions& at) noexcept {
  return dual(at);
}
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] void give_on_avx2(const Compliance& compliance, const Forces& forces) noexcept {
  give(compliance, forces);
}
[[gnu::target("avx2,fma")]] Dual dual_on_avx2(const Tractions& at) noexcept {
  return dual(at);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] void give_on_avx512(const Compliance& compliance,
                                                                 const Forces& forces) noexcept {
  give(compliance, forces);
}
[[gnu::target("avx512f,avx512vl,avx512dq")]] Dual dual_on_avx512(const Tractions& at) noexcept {
  return dual(at);
}
#endif

struct PartialSlipKernels {
  void (*give)(const Compliance&, const Forces&) noexcept;
  Dual (*dual)(const Tractions&) noexcept;
  static const PartialSlipKernels baseline, avx2, avx512;  // chosen by best_kernels
};
const PartialSlipKernels PartialSlipKernels::baseline{give_on_baseline, dual_on_baseline};
#if defined(__x86_64__)
const PartialSlipKernels PartialSlipKernels::avx2{give_on_avx2, dual_on_avx2};
const PartialSlipKernels PartialSlipKernels::avx512{give_on_avx512, dual_on_avx512};
#endif

const Compliance& compliance() noexcept {
  static const Compliance kCompliance;
  return kCompliance;
}

// The largest eigenvalue of the compliance, by its powers; a little more, so that a gradient step of its
// inverse never climbs.
double stiffest() noexcept {
  constexpr int kPowers = 30;
  constexpr double kRoom = 1.01;
  PartialSlip::Cells in{}, zero{}, out{}, unused{};
  in.fill(1);
  double norm = 1;
  for (int i = 0; i < kPowers; ++i) {
    best_kernels<PartialSlipKernels>().give(compliance(),
                                            {in.data(), zero.data(), out.data(), unused.data(), 0, kSide});
    double squares = 0;
    for (const float value : out) squares += static_cast<double>(value) * static_cast<double>(value);
    norm = std::sqrt(squares);
    for (std::size_t cell = 0; cell < out.size(); ++cell)
      in[cell] = static_cast<float>(static_cast<double>(out[cell]) / norm);
  }
  return kRoom * norm;
}

double greatest_give() noexcept {
  static const double kGreatest = stiffest();
  return kGreatest;
}

// The step against the slope, or 0 where the curvature vanishes.
std::array<double, 3> newton(const Dual& at, const std::array<double, 3>& s) noexcept {
  constexpr double kRound =
      1e-9;  // of the curvature: a contact that slides all over has none along its motion
  const double xx = at.xx + kRound * (at.xx + at.yy), yy = at.yy + kRound * (at.xx + at.yy);
  const double tt = at.tt * (1 + kRound) + kRound * (at.xx + at.yy);
  const double a = yy * tt - at.yt * at.yt, b = at.xt * at.yt - at.xy * tt, c = at.xy * at.yt - yy * at.xt;
  const double d = xx * tt - at.xt * at.xt, e = at.xy * at.xt - xx * at.yt, f = xx * yy - at.xy * at.xy;
  const double det = xx * a + at.xy * b + at.xt * c;
  if (!(det > 0)) return {};
  return {-(a * s[0] + b * s[1] + c * s[2]) / det, -(b * s[0] + d * s[1] + e * s[2]) / det,
          -(c * s[0] + e * s[1] + f * s[2]) / det};
}

}  // namespace

PartialSlip::PartialSlip(const PartialSlipOptions& options) noexcept : options_(options) {
  greatest_give();
}

void PartialSlip::release(double side_m) noexcept {
  side_m_ = side_m;
  load_ = {};
  used_share_ = limit_sum_n_ = 0;
  at_ = reference_at_ = {};
  motion_ = {};
  restarted_ = false;
  for (Cells* cells : {&limit_, &x_, &y_, &reference_x_, &reference_y_}) cells->fill(0);
}

void PartialSlip::restart(const Cells& shear_x_n, const Cells& shear_y_n) noexcept {
  x_ = reference_x_ = shear_x_n;
  y_ = reference_y_ = shear_y_n;
  motion_ = {};
  restarted_ = true;
}

void PartialSlip::limit(const Cells& normal_n, double friction) noexcept {
  limit_sum_n_ = 0;
  first_row_ = kSide;
  end_row_ = 0;
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    const double most = friction * std::max(0.0, static_cast<double>(normal_n[cell]));
    limit_[cell] = static_cast<float>(most);
    limit_sum_n_ += most;
    if (!(most > 0)) x_[cell] = y_[cell] = 0;
    // Traction that the rim took with it moves what is left.
    if (!(most > 0) && reference_x_[cell] == 0 && reference_y_[cell] == 0) continue;
    first_row_ = std::min(first_row_, cell / kSide);
    end_row_ = std::max(end_row_, cell / kSide + 1);
  }
}

// The limit surface in squares of two by two cells: forces in N, lengths in cells.
PlaneLoad PartialSlip::within_limit(const PlaneLoad& load) noexcept {
  // Of four forces in the corners of a square: as an even pressure over this side.
  const double side = std::sqrt(3.0);
  surface_.clear(side);
  for (std::size_t row = first_row_ / 2 * 2; row < end_row_; row += 2) {
    for (std::size_t column = 0; column < kSide; column += 2) {
      double sum = 0, by_x = 0, by_y = 0;
      for (const std::size_t cell : {row * kSide + column, row * kSide + column + 1,
                                     (row + 1) * kSide + column, (row + 1) * kSide + column + 1}) {
        const auto force = static_cast<double>(limit_[cell]);
        sum += force;
        by_x += force * column_of(cell);
        by_y += force * row_of(cell);
      }
      if (sum > 0) surface_.add(by_x / sum, by_y / sum, sum);
    }
  }
  used_share_ = surface_.least_friction(load.shear_x_n, load.shear_y_n, load.torque_nm / side_m_).ratio;
  const double part = used_share_ > options_.most_share ? options_.most_share / used_share_ : 1;
  return {part * load.shear_x_n, part * load.shear_y_n, part * load.torque_nm};
}

PartialSlip::Point PartialSlip::point_of(const PlaneLoad& load) const noexcept {
  const double half_m = side_m_ * static_cast<double>(kSide) / 2;
  return {load.shear_x_n, load.shear_y_n, load.torque_nm / half_m, limit_sum_n_};
}

// Where the way of the load bends, or has gone far, a new increment begins with the present tractions.
void PartialSlip::refer(const Point& next) noexcept {
  if (std::exchange(restarted_, false)) at_ = reference_at_ = next;
  constexpr double kStraight = 0.9;  // cosine of the angle by which the way may bend within an increment
  double along = 0, so_far = 0, step = 0;
  for (std::size_t i = 0; i < next.size(); ++i) {
    const double gone = at_[i] - reference_at_[i], to_go = next[i] - at_[i];
    along += gone * to_go;
    so_far += gone * gone;
    step += to_go * to_go;
  }
  const double unit = std::max(limit_sum_n_, reference_at_[3]);
  if (so_far > 0 &&
      (along < kStraight * std::sqrt(so_far * step) || so_far > kIncrement * kIncrement * unit * unit)) {
    reference_x_ = x_;
    reference_y_ = y_;
    reference_at_ = at_;
  }
  at_ = next;
}

void PartialSlip::carry(const Cells& normal_n, double friction, const PlaneLoad& load) noexcept {
  limit(normal_n, friction);
  steps_ = 0;
  if (!(limit_sum_n_ > 0)) {
    release(side_m_);
    return;
  }
  load_ = within_limit(load);
  refer(point_of(load_));
  solve({load_.shear_x_n, load_.shear_y_n, load_.torque_nm / side_m_});
}

void PartialSlip::solve(const Sums& target) noexcept {
  const auto& kernels = best_kernels<PartialSlipKernels>();
  const auto step = static_cast<float>(1 / greatest_give());
  double limits = 0;
  for (const float most : limit_) limits += static_cast<double>(most) * static_cast<double>(most);
  const double settled = kSettled * kSettled * limits;
  trial_x_ = x_;
  trial_y_ = y_;
  motion_ = {};  // that of a load that slid is far from any other
  double momentum = 1;
  for (steps_ = 1; steps_ <= options_.most_steps; ++steps_) {
    for (std::size_t cell = 0; cell < kCells; ++cell) {
      dx_[cell] = trial_x_[cell] - reference_x_[cell];
      dy_[cell] = trial_y_[cell] - reference_y_[cell];
    }
    kernels.give(compliance(),
                 {dx_.data(), dy_.data(), give_x_.data(), give_y_.data(), first_row_, end_row_});
    for (std::size_t cell = first_row_ * kSide; cell < end_row_ * kSide; ++cell) {
      dx_[cell] = trial_x_[cell] - step * give_x_[cell];
      dy_[cell] = trial_y_[cell] - step * give_y_[cell];
    }
    project(target);  // dx_, dy_ to give_x_, give_y_
    double moved = 0, against = 0;
    for (std::size_t cell = first_row_ * kSide; cell < end_row_ * kSide; ++cell) {
      const float to_x = give_x_[cell] - x_[cell], to_y = give_y_[cell] - y_[cell];
      moved += static_cast<double>(to_x * to_x + to_y * to_y);
      against += static_cast<double>((trial_x_[cell] - give_x_[cell]) * to_x +
                                     (trial_y_[cell] - give_y_[cell]) * to_y);
    }
    if (against > 0) momentum = 1;
    const double next = (1 + std::sqrt(1 + 4 * momentum * momentum)) / 2;
    const auto on = static_cast<float>((momentum - 1) / next);
    momentum = next;
    for (std::size_t cell = first_row_ * kSide; cell < end_row_ * kSide; ++cell) {
      trial_x_[cell] = give_x_[cell] + on * (give_x_[cell] - x_[cell]);
      trial_y_[cell] = give_y_[cell] + on * (give_y_[cell] - y_[cell]);
      x_[cell] = give_x_[cell];
      y_[cell] = give_y_[cell];
    }
    if (moved < settled) break;
  }
}

// The point within friction and with the sums `target` that is next to (dx_, dy_): each cell is moved by one
// rigid motion and cut to its limit. The motion is the minimum of a convex function of three unknowns.
void PartialSlip::project(const Sums& target) noexcept {
  constexpr int kMostHalvings = 12;
  constexpr double kExact = 1e-6;  // of mu P
  const auto& kernels = best_kernels<PartialSlipKernels>();
  const auto at = [&](const std::array<double, 3>& motion) {
    Dual sums = kernels.dual(
        {dx_.data(), dy_.data(), limit_.data(), first_row_, end_row_, motion[0], motion[1], motion[2]});
    sums.value -= motion[0] * target.x + motion[1] * target.y + motion[2] * target.turn;
    return sums;
  };
  Dual now = at(motion_);
  for (int step = 0; step < kMostSteps; ++step) {
    const std::array<double, 3> slope{now.x - target.x, now.y - target.y, now.turn - target.turn};
    if (std::fabs(slope[0]) + std::fabs(slope[1]) + std::fabs(slope[2]) * 2 / static_cast<double>(kSide) <
        kExact * limit_sum_n_)
      break;
    const auto by = newton(now, slope);
    double part = 1;
    std::array<double, 3> there{};
    Dual next;
    for (int halving = 0; halving <= kMostHalvings; ++halving, part /= 2) {
      there = {motion_[0] + part * by[0], motion_[1] + part * by[1], motion_[2] + part * by[2]};
      next = at(there);
      if (next.value < now.value) break;
    }
    if (!(next.value < now.value)) break;
    motion_ = there;
    now = next;
  }
  for (std::size_t cell = first_row_ * kSide; cell < end_row_ * kSide; ++cell) {
    const auto most = static_cast<double>(limit_[cell]);
    const double qx = static_cast<double>(dx_[cell]) + motion_[0] - motion_[2] * row_of(cell);
    const double qy = static_cast<double>(dy_[cell]) + motion_[1] + motion_[2] * column_of(cell);
    const double size = std::sqrt(qx * qx + qy * qy), part = size > most ? most / size : 1;
    give_x_[cell] = static_cast<float>(part * qx);
    give_y_[cell] = static_cast<float>(part * qy);
  }
}

}  // namespace slipd::contact
