// A contact's pressure as at most some hundred cells, for the limit surface (core/contact/limit_surface.hpp):
// each has the force of its taxels, at their own centre. A layout with few taxels in the disc has a cell for
// each. Estimate thread; allocates in its constructor only.
#pragma once

#include <array>
#include <vector>

#include "core/contact/limit_surface.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

class PressureCells {
 public:
  explicit PressureCells(const TaxelLayout& layout);

  // Of this contact, about its centre; valid until the next call.
  const contact::LimitSurface& pool(const ContactPatch& patch) noexcept;
  // Whether each cell of the last call is one taxel.
  bool are_taxels() const noexcept { return taxels_; }

 private:
  // Cells across the disc at most. Error of T_max by pooling, of Hertz: 4e-4 with 12, 1e-2 with 4 (each
  // cell's force lies at its centre of pressure, and its spread is that of an even pressure).
  static constexpr std::size_t kAcross = 12;
  static_assert(kAcross * kAcross <= contact::LimitSurface::kMost);

  struct Box {
    std::size_t first_row = 0, end_row = 0, first_column = 0, end_column = 0;
  };
  // Sums over the taxels of one cell: force, and its moments by x and y.
  struct Cell {
    double normal = 0, x = 0, y = 0;
  };

  double spread_side(double across) const noexcept;
  Box box_of(const ContactPatch& patch) const noexcept;
  void pool_grid(const ContactPatch& patch) noexcept;
  void end_band(const ContactPatch& patch, const Box& box, std::size_t first_row, std::size_t rows,
                std::size_t across) noexcept;
  void pool_scattered(const ContactPatch& patch) noexcept;

  TaxelLayout layout_;
  const DiscKernels& kernels_;
  contact::LimitSurface surface_;
  std::vector<float> sums_, moments_;  // of each column of a band of rows: p, and p times the row in the band
  bool taxels_ = false;
  std::array<Cell, kAcross * kAcross> cells_{};
};

}  // namespace slipd
