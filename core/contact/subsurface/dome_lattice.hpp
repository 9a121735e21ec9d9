// The averaged dome over squares that lie side by side (docs/theory.md §5.1). Neighbours share corners, so
// that the closed form is computed once for each corner and not four times for each square. The inner loop
// exists once per instruction set and is chosen at run time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/contact/subsurface/dome.hpp"
#include "core/contact/subsurface/dome_rings.hpp"
#include "core/simd/taxel_runs.hpp"

namespace slipd::contact {

// Squares of a regular grid: of each row, from the lowest to the highest, the columns of one run. Squares are
// numbered in order of rows.
struct SquareLattice {
  // Left edge of column 0 and lower edge of row 0, m.
  double left_m = 0, bottom_m = 0;
  // Of each square, m.
  double side_m = 1;
  // Columns [first, end) of each row; a run may be empty.
  std::span<const TaxelRun> rows;
};

// Not thread-safe. Allocates in its constructor only.
class DomeLattice {
 public:
  // most_along: rows of a lattice, and its columns, at most.
  explicit DomeLattice(std::size_t most_along);

  // The squares that the next evaluations are about.
  void set(const SquareLattice& lattice) noexcept;

  // Averages for a dome of radius x about (center_x, center_y), and their derivatives; see DomeAverage. All
  // spans have room for a value of each square. Exact to rounding. x >= 0; lengths in m.
  void evaluate(double x, double center_x_m, double center_y_m, const DomeAverages& out) noexcept;

  // What domes of these radii leave of `whole`, which has a value of each square as `field` has. In single
  // precision: an average is good to 1e-6 x^3/side^2.
  RingSums ring_sums(const PerRing& radii, double center_x_m, double center_y_m,
                     std::span<const double> whole, std::span<const double> field) noexcept;

  std::size_t memory_bytes() const noexcept {
    return sizeof(double) * kLists * u_.size() + sizeof(CornerRow) * rows_.capacity() +
           2 * sizeof(PerRing) * below_.size();
  }

 private:
  void put(const std::vector<double>& of, std::span<double> to) const noexcept;

  static constexpr std::size_t kLists = 6;
  // Corners of one height: those of columns [first, first + count), from number `start` on.
  struct CornerRow {
    std::uint32_t first = 0, count = 0, start = 0;
  };

  double side_m_ = 1;
  std::span<const TaxelRun> squares_;
  std::vector<CornerRow> rows_;
  std::size_t corners_ = 0;
  std::vector<double> u_, v_, value_, d_x_, d_u_, d_v_;
  std::vector<PerRing> below_, above_;  // of two rows of corners
};

}  // namespace slipd::contact
