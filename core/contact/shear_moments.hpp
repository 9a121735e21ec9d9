// How shear lies between a contact's centre and its rim, whatever the contact went through: two moments of it
// (docs/theory.md §7.2), with u = r^2/a^2. A disc D_x has <u> = 2 x^2/5 and <u^2> = 8 x^4/35.
#pragma once

#include <array>

namespace slipd::contact {

// In N and signed like Q.
struct ShearMoments {
  // Q (5/3 - 5/2 <u>_q): what slip has taken from the rim. 0 where all sticks under a constant normal force.
  double slip_moment_n = 0;
  // Q <6 u^2 - 6 u + 1>_q: rim and centre against what is between. Noise on it is uncorrelated with Q's
  // and with the other's.
  double second_legendre_n = 0;
};

// Those of 1 N on a disc whose radius squared is u times the contact's; u > 0.
constexpr ShearMoments moments_of_disc(double u) noexcept {
  return {.slip_moment_n = 5.0 / 3 - u, .second_legendre_n = 48.0 / 35 * u * u - 12.0 / 5 * u + 1};
}

// Shear of any history of loads is a sum of discs (Jäger 1998). Radii of those that methods look for, over
// the contact's. Fewer, or none near 1: a stick zone between two of them is read wrong. More: noise, and
// time.
inline constexpr std::array kDiscRadii{1.0, 0.94, 0.8, 0.6, 0.35};

}  // namespace slipd::contact
