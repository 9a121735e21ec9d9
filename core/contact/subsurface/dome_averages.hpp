// Domes averaged over taxels at any places (docs/theory.md §5.1), by the closed form: exact to rounding. For
// taxels side by side DomeLattice takes less time. Any thread; nothing allocates. The loops exist once per
// instruction set and are chosen at run time.
#pragma once

#include <span>

#include "core/contact/subsurface/dome.hpp"

namespace slipd::contact {

// The average over squares of `side` about (u, v) of a dome of radius x about the origin, and its
// derivatives; see DomeAverage. All spans have one size. x >= 0; lengths in one unit.
void average_dome(double x, double side, std::span<const double> u, std::span<const double> v,
                  const DomeAverages& out) noexcept;

// The averages alone.
void average_dome(double x, double side, std::span<const double> u, std::span<const double> v,
                  std::span<double> value) noexcept;

}  // namespace slipd::contact
