// Cattaneo and Mindlin (docs/theory.md §3): a Hertzian contact at constant normal force whose tangential load
// rises from zero. A rim slips, a stick zone of radius c = a cbrt(Gamma) is left. For loads that fall,
// reverse or come with the force, see history.hpp.
#pragma once

#include "core/contact/hertz.hpp"

namespace slipd::contact {

// What the skin senses at one radius.
struct Traction {
  double pressure_pa = 0;  // p, >= 0
  double shear_pa = 0;     // q, >= 0, along the load
  double angle_rad = 0;    // alpha = atan(q/p) in [0, atan(mu)]; at the rim its limit, outside the contact 0
};

class CattaneoMindlin {
 public:
  // normal_n: P >= 0. friction: mu > 0. one_minus_gamma: Q/(mu P) in [0, 1]; it is given, and not Gamma,
  // because a small load would lose its digits in 1 - Gamma. Throws ContactError otherwise.
  CattaneoMindlin(const BodyPair& pair, double normal_n, double friction, double one_minus_gamma);

  double contact_radius_m() const noexcept { return a_; }
  double peak_pressure_pa() const noexcept { return p0_; }
  double stick_radius_m() const noexcept { return a_ * k_; }
  double shear_n() const noexcept { return load_ * friction_ * normal_; }
  double safety_margin() const noexcept { return 1 - load_; }

  // s = r/a >= 0. All three vanish for s > 1 and where nothing presses.
  Traction at(double s) const noexcept;

  // q/(mu p) in [0, 1], computed as a ratio so that it keeps its digits at the rim (0/0) and for the smallest
  // load.
  double mobilised_friction(double s) const noexcept;

 private:
  double normal_, friction_, load_;
  double a_, p0_;
  double k_;             // c/a = cbrt(Gamma)
  double one_minus_k2_;  // 1 - k^2 without cancellation
};

}  // namespace slipd::contact
