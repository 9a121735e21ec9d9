// A contact's load history in short: the same springs as in history.hpp (Popov's dimensionality reduction),
// but a fixed number of them and no materials, for whoever has to follow many histories at once: the
// estimator does so side by side (core/estimate/spring_beds), which is held against this, the plain form. A
// spring at x touches from the pressure on at which the contact's radius is x; it sticks, or slips at
// friction times its own load. Lengths are in units of the radius that 1 N makes, so that a = cbrt(P)
// whatever touches what.
//
// Within 0.005 mu P of the exact history in shape() for a load that the springs resolve (see follow).
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

  // How the shear lies between centre and rim, in N and signed like Q, u = r^2/a^2:
  struct Shape {
    // Q (5/3 - 5/2 <u>_q): what slip has taken from the rim. 0 while all sticks, and hardly changed by a load
    // that changes without slip.
    double slipped_n = 0;
    // Q <6 u^2 - 6 u + 1>_q: rim and centre against what is between. Noise on it is independent of Q's and of
    // the other's.
    double hollow_n = 0;
  };
  // (A disc D_x has <u> = 2 x^2/5 and <u^2> = 8 x^4/35, so a spring at x counts with 2 x^2 and 8/3 x^4.)
  Shape shape() const noexcept;

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
