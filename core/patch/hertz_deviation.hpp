// How a contact's pressure differs from Hertz's: tilted, elliptic, or with its load farther out, as under a
// skin that spreads stress (docs/methods.md §20.6). It is computed from a few sums over the disc, so that
// each frame shows how far to trust it. Estimate thread; nothing allocates.
#pragma once

#include "core/patch/patch.hpp"

namespace slipd {

inline constexpr double kSquareFourth = 0.0389;  // <r^4> of a square of side 1 about its middle: 7/180

// What square taxels on a round rim make of an ellipticity, and of each part of a moment of the pattern, over
// (side/a)^3; 0 … 1. On Hertz contacts anywhere on a grid, side/a from 0.1 to 1, the largest part of a moment
// is 0.6 of this, and 4 times their root mean square. Too small: the grid's own directions pass for the
// object's. Too large: coarse arrays see no ellipse and give no angle.
inline constexpr double kRimShare = 0.16;

// All dimensionless. Values and their checks: `slipd-lab stability --parts adversary` on 16 x 16 to 100 x 100
// taxels, which gives what Gamma is off by over each deviation. side: a taxel's side; a: the contact's
// radius.
struct HertzDeviationOptions {
  // What square taxels on a round rim make of tilt and kurtosis, over (side/a)^3; 0 … 2. Too small: coarse
  // arrays refuse round contacts. Too large: coarse arrays see no deviation.
  double rim = 0.7;
  // What a taxel that senses less than its whole square makes of the excess kurtosis, over (side/a)^2; 0 … 1.
  // Too small and too large: as above.
  double point_kurtosis = 0.2;
  // From here on a frame gives no margin of its own; 0 … 1 and 0 … 0.5. Too small: usable contacts are
  // refused. Too large: margins are given for contacts of another kind, and sigma does not cover their error.
  double max_ellipticity = 0.5;
  double max_kurtosis = 0.06;
};

// Each is 0 where noise and the taxels' size may be all of it.
struct HertzDeviation {
  // t of a pressure that is Hertz's times 1 + t x/a; dimensionless, >= 0.
  double tilt = 0;
  // (long^2 - short^2)/(long^2 + short^2) of its axes; 0 … 1.
  double ellipticity = 0;
  // Direction of the long axis from x to y, -pi/2 … pi/2; means nothing where the ellipticity is 0.
  double long_axis_rad = 0;
  // Magnitude of <r^4>/<r^2>^2 less that of a Hertz contact of the same ellipticity; dimensionless, >= 0.
  double excess_kurtosis = 0;

  // Near enough to Hertz's for a frame to give a margin at all.
  bool hertzian(const HertzDeviationOptions& options = {}) const noexcept;

  // The standard deviation of Gamma that it costs.
  double sigma(const HertzDeviationOptions& options = {}) const noexcept;
};

// Of a whole contact: not cut by the sensor's edge. `sums` are of its patch.
HertzDeviation hertz_deviation(const MomentSums& sums, const ContactPatch& patch, double side_m,
                               const HertzDeviationOptions& options = {}) noexcept;

}  // namespace slipd
