// A contact's load history in short: the same springs as in history.hpp (Popov's dimensionality reduction),
// but a fixed number of them and no materials, for whoever has to follow many histories at once. A spring at
// x touches from the pressure on at which the contact's radius is x; it sticks, or slips at friction times
// its own load. Lengths are in units of the radius that 1 N makes, so that a = cbrt(P) whatever touches what.
//
// Within 0.005 mu P of the exact history in slipped_n() for a load that the springs resolve (see follow).
// Plain memory, nothing allocates or throws.
#pragma once

#include <array>
#include <cstddef>

namespace slipd::contact {

class SpringBed {
 public:
  // No contact.
  void clear() noexcept;

  // The load goes straight to normal_n >= 0 and shear_n (signed) at this friction > 0; shear beyond mu P is
  // not carried. Finite numbers only. A normal force below a thousandth of the largest one since clear() is
  // felt by too few springs to mean anything.
  void follow(double normal_n, double shear_n, double friction) noexcept;

  // Forgets the past: shear rose from nothing to shear_n under a normal force that did not change.
  void assume_risen(double normal_n, double shear_n, double friction) noexcept;

  double shear_n() const noexcept { return shear_n_; }

  // 5/3 Q - Q <r^2>_q / <r^2>_p in N, signed like Q: what slip has taken from the rim. 0 while all sticks,
  // and hardly changed by a load that changes without slip. (A disc D_x has <r^2> = 2 x^2/5, so a spring at x
  // counts with 2 x^2.)
  double slipped_n() const noexcept;

 private:
  static constexpr std::size_t kSprings = 48;
  using Row = std::array<float, kSprings>;

  void reach(double radius) noexcept;
  void limits(double edge, double friction, Row& most) const noexcept;
  void settle(const Row& most, double target) noexcept;
  double touching(double edge) const noexcept;

  double step_ = 0;  // between springs; spring i stands at (i + 1/2) step
  double normal_n_ = 0, shear_n_ = 0;
  Row load_{};  // what each carries
};

}  // namespace slipd::contact
