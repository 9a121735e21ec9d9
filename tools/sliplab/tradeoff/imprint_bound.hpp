// The Cramér–Rao bound of contacts under a skin and of ellipses: the guide beside what method fit reaches.
#pragma once

#include "core/contact/subsurface.hpp"
#include "core/estimate/imprint_model.hpp"

namespace sliplab {

// The true parameters of a contact.
struct KnownImprint {
  // Its centre, m.
  double x_m = 0, y_m = 0;
  // The ellipse that it covers; 0 < a, b.
  slipd::contact::Ellipse ellipse;
  // Q/P > 0, Gamma in (0, 1), and the direction of Q from x to y, rad.
  double load = 0, gamma = 0, pull_rad = 0;
};

// The bound of Gamma's standard deviation, for Gaussian noise of this standard deviation on all channels,
// over the greatest pressure that is read; for a round contact the axes are not unknowns. Infinite where the
// frame has no information. Overwrites what the model holds.
double cramer_rao_sigma(slipd::ImprintModel& model, const KnownImprint& truth, double noise_share) noexcept;

}  // namespace sliplab
