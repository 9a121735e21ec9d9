// How shear lies between a contact's centre and its rim, whatever the contact went through: two moments of it
// (docs/theory.md §7.2), with u = r^2/a^2. A disc D_x has <u> = 2 x^2/5 and <u^2> = 8 x^4/35.
#pragma once

namespace slipd::contact {

// In N and signed like Q.
struct ShearMoments {
  // Q (5/3 - 5/2 <u>_q): what slip has taken from the rim. 0 where all sticks under a constant normal force.
  double slip_moment_n = 0;
  // Q <6 u^2 - 6 u + 1>_q: rim and centre against what is between. Noise on it is uncorrelated with Q's
  // and with the other's.
  double second_legendre_n = 0;
};

}  // namespace slipd::contact
