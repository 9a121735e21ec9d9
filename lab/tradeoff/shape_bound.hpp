// The Cramér–Rao bounds of contacts under a skin and of other shapes: the guides beside what methods reach.
#pragma once

#include <cstddef>

#include "core/contact/contact_field.hpp"
#include "core/contact/hertz.hpp"
#include "core/contact/subsurface/subsurface.hpp"
#include "core/reading/fit/normal_equations/contact_shape.hpp"

namespace lab {

// The true parameters of a contact.
struct KnownContact {
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
double cramer_rao_sigma(slipd::ContactShape& model, const KnownContact& truth, double noise_share) noexcept;

// The same for a method that knows what the contact of this pair is sensed as under each force, as method
// closing does without noise: of any shape. Not known are Gamma, the pull, the normal force, and whether the
// pressure has been shifted. taxels: of the sheet. Of `truth` the ellipse is not read. Allocates.
double cramer_rao_sigma_by_closing(slipd::contact::ContactField& sheet, std::size_t taxels,
                                   const slipd::contact::BodyPair& pair, double normal_n,
                                   const KnownContact& truth, double noise_share);

}  // namespace lab
