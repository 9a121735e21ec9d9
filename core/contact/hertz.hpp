// Two spheres pressed together without load along the surface (Hertz, docs/theory.md §2): how large the
// contact is, how the pressure lies. Closed forms in the shape that survives floating point. Free functions
// of plain values, callable from any thread.
#pragma once

#include <stdexcept>

#include "core/contact/scene.hpp"

namespace slipd::contact {

// What is laid over a contact, cells or springs, reaches this far when it is made, over the contact's radius;
// 1.05 … 3. Too small: a growing contact soon needs another, and each time interpolates. Too large: cells are
// coarse, and few springs touch. Checked with `slipd-lab histories --grasps 400`.
inline constexpr double kSpare = 1.15;

// An input without physical meaning; says which, its value, and what it must be.
class ContactError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

// One of the two bodies. radius_m: positive convex, infinity flat, negative concave. modulus_pa: Young's
// modulus E > 0. poisson: nu in (-1, 0.5].
struct Body {
  double radius_m = 0;
  double modulus_pa = 0;
  double poisson = 0;
};

inline Body body_of(const Skin& skin) {
  return {skin.radius_m, skin.modulus_pa, skin.poisson};
}

// The pair of bodies, whatever the force: E* and R (docs/theory.md §2).
struct BodyPair {
  double modulus_pa = 0;  // E*, from 1/E* = (1-nu1^2)/E1 + (1-nu2^2)/E2
  double radius_m = 0;    // R, from 1/R = 1/R1 + 1/R2

  // Both from the normal force in N, >= 0; for 0 the contact has no extent.
  double contact_radius_m(double normal_n) const noexcept;  // a = cbrt(3PR / 4E*)
  double peak_pressure_pa(double normal_n) const noexcept;  // p0 = 3P / (2 pi a^2)

  // D_x, the disc term that pressure and shear are made of (docs/theory.md §2):
  // disc_scale() * sqrt(x^2 - r^2) for r < x, in Pa; its integral is disc_force_n(x).
  double disc_scale_pa_per_m() const noexcept;               // 2 E* / (pi R)
  double disc_force_n(double disc_radius_m) const noexcept;  // P(x) = 4 E* x^3 / (3 R)
};

// Throws ContactError unless both moduli are positive and finite, both nu in (-1, 0.5], no radius is 0 or
// NaN, and 1/R1 + 1/R2 > 0 (two flats, or a concave body as tight as the other, have no Hertzian contact).
BodyPair make_body_pair(const Body& sensor, const Body& object);

// Throws ContactError unless the force is finite and not negative.
void check_normal_force(double normal_n);

// Throws ContactError unless friction is finite and positive.
void check_friction(double friction);

}  // namespace slipd::contact
