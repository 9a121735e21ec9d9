// Domes of several radii about one centre at once, and the rings that they leave of a wider one: the shear of
// a partial slip for each margin (docs/theory.md §3). Squares are those of a lattice or any others. Any
// thread; nothing allocates. The loops exist once per instruction set and are chosen at run time.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace slipd::contact {

inline constexpr std::size_t kRings = 24;
// Of each ring, one value after the other: loops over rings are what processors do side by side.
using PerRing = std::array<float, kRings>;

// Of each ring, over squares: the sum of its squared averages, and of their products with a field.
struct RingSums {
  std::array<double, kRings> squares{}, products{};
};

// Domes of these radii >= 0, integrated over the rectangles from their centre to each corner (u, v); see
// DomeCorner. In single precision: an error of w, the height above the rim, does not count there, where w is
// small. The spans have one size; lengths in one unit.
void integrate_domes(const PerRing& radii, std::span<const double> u, std::span<const double> v,
                     double center_u, double center_v, std::span<PerRing> corners) noexcept;

// Squares that lie side by side, between corners: square i has corners i and i + 1 of both rows.
struct SquareRow {
  const PerRing *below, *above;
  // Of each square: the average of the wider dome, and the field.
  std::span<const double> whole, field;
  double per_area;
};
void add_rings(const SquareRow& squares, RingSums& sums) noexcept;

}  // namespace slipd::contact
