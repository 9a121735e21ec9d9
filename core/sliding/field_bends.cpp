#include "core/sliding/field_bends.hpp"

#include <cmath>
#include <stdexcept>

namespace slipd {
namespace {

TaxelLayout::Grid grid_of(const TaxelLayout& layout) {
  const auto& grid = layout.regular();
  if (grid && grid->columns >= FieldBends::kLeast && grid->rows >= FieldBends::kLeast) return *grid;
  throw std::invalid_argument(
      "a sensor whose frames are displacements in mm needs a layout that is a grid of at least 3 x 3 points");
}

}  // namespace

FieldBends::FieldBends(const TaxelLayout& layout)
    : grid_(grid_of(layout)),
      values_(2 * (grid_.rows * (grid_.columns - 2) + (grid_.rows - 2) * grid_.columns)) {}

void FieldBends::take(const Frame& frame, std::size_t middle, std::size_t step) noexcept {
  for (const std::span<const float> u : {frame.shear_x_pa, frame.shear_y_pa}) {
    const float bend = u[middle - step] - 2 * u[middle] + u[middle + step];
    if (std::isfinite(bend)) values_[next_] = bend;
    ++next_;
  }
}

std::span<const float> FieldBends::update(const Frame& frame) noexcept {
  next_ = 0;
  const std::size_t columns = grid_.columns;
  for (std::size_t row = 0; row < grid_.rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t middle = row * columns + column;
      if (column > 0 && column + 1 < columns) take(frame, middle, 1);
      if (row > 0 && row + 1 < grid_.rows) take(frame, middle, columns);
    }
  }
  return values_;
}

}  // namespace slipd
