// Columns of linear least squares over taxels of a contact under a skin or of an ellipse: what taxels sense
// of one dome, and products of columns, in loops that run on vectors. Estimate thread; nothing allocates.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/contact/subsurface/subsurface.hpp"

namespace slipd {

// Lists of a SubsurfaceSheet's components, by Sheet::Component.
using SensedRows = std::array<const double*, contact::SubsurfaceSheet::kComponents>;
SensedRows sensed_rows(const contact::SubsurfaceSheet& sheet, contact::SubsurfaceSheet::Of of) noexcept;

// A pressure and a shear on one dome, and a shear on another.
struct DesignColumn {
  SensedRows dome, other;
  // Of the domes' height, Pa; along the sensor's axes.
  double pressed_pa = 0, pulled_x_pa = 0, pulled_y_pa = 0, other_x_pa = 0, other_y_pa = 0;
  // One over the noise of a taxel, 1/Pa.
  double per_normal = 1, per_shear = 1;
};

// Fills `to` with what `count` taxels sense, in units of noise: pressures of all, then both shears.
void fill_sensed(const DesignColumn& column, std::size_t count, double* to) noexcept;

// Products of columns of `rows` numbers with each other, the lower half row by row.
void multiply_columns(std::span<const double* const> columns, std::size_t rows, double* products) noexcept;

}  // namespace slipd
