// How a contact's pressure lies otherwise than Hertz's: to one side, longer than wide, or farther out, as
// under a skin that spreads stress (docs/theory.md §7.3). Read off a few sums over the disc, so that each
// frame can tell how far to trust it.
#pragma once

#include "core/patch/patch.hpp"

namespace slipd {

inline constexpr double kSquareFourth = 0.0389;  // <r^4> of a square of side 1 about its middle

// Each is 0 where noise and the taxels' size may be all of it.
struct HertzDeviation {
  double tilt = 0;             // t of a pressure that is Hertz's times 1 + t x/a
  double ellipticity = 0;      // (long^2 - short^2)/(long^2 + short^2) of its axes
  double excess_kurtosis = 0;  // of <r^4>/<r^2>^2, off what it is of a contact as long as this one

  bool hertzian() const noexcept;  // near enough for a margin to be read at all
  double sigma() const noexcept;   // the deviation of Gamma that it costs, measured on contacts like that
};

// Of a whole contact: not cut by the sensor's edge. `sums` are of its patch.
HertzDeviation hertz_deviation(const MomentSums& sums, const ContactPatch& patch, double side_m) noexcept;

}  // namespace slipd
