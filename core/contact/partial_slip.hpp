// Partial slip under a force and a torque at once: the shear of an elastic half space whose contact carries Q
// along the surface and T about its normal, with |q| <= mu p everywhere, for any pressure and any history of
// the load (docs/theory.md §4.5).
//
// The history is followed in increments. An increment from the tractions q' changes them to those q, within
// friction and with the sums Q and T, for which (q - q') A (q - q')/2 is least, A the compliance of the
// surface (Cerruti's kernel for nu = 0, which is that of a single direction). Its multipliers are the rigid
// shift and turn of the object; the cells that do not reach friction stick to it (Kalker 1990).
//
// Method: projected gradient with momentum (Nesterov 1983). The projection onto all constraints at once has
// three unknowns, and is solved by Newton's method; by itself it is a Winkler bed.
//
// Fixed memory: nothing allocates or throws. Not shared between threads.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/contact/limit_surface.hpp"

namespace slipd::contact {

// What a contact carries along its surface. Through and about the grid's middle.
struct PlaneLoad {
  double shear_x_n = 0;  // force on the sensor, N
  double shear_y_n = 0;  // N
  double torque_nm = 0;  // about the normal, N m, positive from x to y
  bool operator==(const PlaneLoad&) const = default;
};

// The load's way, as a share of mu P, that is one increment, 0.02 … 0.5: up to it an increment's beginning
// stays the reference, and what is further at once is cut into parts. Too small: costs time, and errors of
// many increments add up. Too large: histories are cut short, and forces that rise together do not stick.
inline constexpr double kIncrement = 0.05;

// Measured on the frames of tests/data/force-and-torque*.bin.
struct PartialSlipOptions {
  // Steps of the gradient for one increment, which ends when one changes the tractions by less than kSettled
  // of mu p, as root mean squares; 10 … 1000. Too small: a large increment is not ended, and the
  // next one goes on with it. Too large: one takes longer. 1 is a Winkler bed.
  int most_steps = 60;
  // Share of the limit surface up to which a load is carried; beyond, the object slides, and the load is
  // carried as far as that; 0.98 … 0.9999. Too small: a sliding contact shows parts that stick. Too large:
  // costs steps.
  double most_share = 0.998;
};

class PartialSlip {
 public:
  // Cells along each side of the grid.
  static constexpr std::size_t kAcross = 24;
  static constexpr std::size_t kCells = kAcross * kAcross;
  using Cells = std::array<float, kCells>;

  explicit PartialSlip(const PartialSlipOptions& options = {}) noexcept;

  // No traction and no history; the cells' squares have this side, m, > 0.
  void release(double side_m) noexcept;
  // The tractions are these from now on, N each cell, whatever came before.
  void restart(const Cells& shear_x_n, const Cells& shear_y_n) noexcept;
  // The load becomes this, with these normal forces of the cells (N, negative ones count as 0) and friction
  // > 0. Beyond the limit surface it is carried in part.
  void carry(const Cells& normal_n, double friction, const PlaneLoad& load) noexcept;

  // N each cell.
  const Cells& shear_x_n() const noexcept { return x_; }
  const Cells& shear_y_n() const noexcept { return y_; }
  // mu times the normal force of each cell, N.
  const Cells& limit_n() const noexcept { return limit_; }
  double side_m() const noexcept { return side_m_; }
  // What is carried of the last load.
  const PlaneLoad& carried() const noexcept { return load_; }
  // The least friction that carries the last load, over friction: 1 - Gamma; above 1 it slides.
  double used_share() const noexcept { return used_share_; }
  // Steps of the last increment.
  int steps() const noexcept { return steps_; }

 private:
  // The load as a point: forces in units of mu P, the torque over half the grid's side, and mu P itself.
  using Point = std::array<double, 4>;
  // Sums of forces and torque; the torque is in N cells.
  struct Sums {
    double x = 0, y = 0, turn = 0;
  };

  void limit(const Cells& normal_n, double friction) noexcept;
  PlaneLoad within_limit(const PlaneLoad& load) noexcept;
  Point point_of(const PlaneLoad& load) const noexcept;
  void refer(const Point& next) noexcept;
  void solve(const Sums& target) noexcept;
  void project(const Sums& target) noexcept;

  PartialSlipOptions options_;
  LimitSurface surface_;  // of the cells' limits
  double side_m_ = 1;
  PlaneLoad load_;
  double used_share_ = 0, limit_sum_n_ = 0;
  int steps_ = 0;
  bool restarted_ = false;                   // the point of the reference is not known yet
  std::size_t first_row_ = 0, end_row_ = 0;  // of the contact
  Point at_{}, reference_at_{};
  std::array<double, 3> motion_{};                   // the projection's multipliers: where its search begins
  alignas(64) Cells limit_{}, x_{}, y_{};            // friction of each cell and what it carries
  alignas(64) Cells reference_x_{}, reference_y_{};  // at the increment's beginning
  alignas(64) Cells trial_x_{}, trial_y_{}, dx_{}, dy_{}, give_x_{}, give_y_{};
};

}  // namespace slipd::contact
