// Residuals, slopes and normal equations of a fit of a contact under a skin or of an ellipse (docs/methods.md
// §23.5), in loops over taxels that run on vectors. Estimate thread; nothing allocates.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/contact/subsurface/subsurface.hpp"
#include "core/reading/fit/normal_equations/slope_block.hpp"

namespace slipd {

// Rows of a sheet, by Sheet::Of.
struct FieldRows {
  using Sheet = contact::SubsurfaceSheet;
  explicit FieldRows(const Sheet& sheet) noexcept {
    for (std::size_t of = 0; of < Sheet::kRows; ++of) {
      for (std::size_t c = 0; c < Sheet::kComponents; ++c)
        row[of][c] = sheet.row(static_cast<Sheet::Of>(of), static_cast<Sheet::Component>(c)).data();
    }
  }
  [[gnu::always_inline]] contact::LayerTensor at(Sheet::Of of, std::size_t i) const noexcept {
    const auto& r = row[of];
    return {r[0][i], r[1][i], r[2][i], r[3][i], r[4][i], r[5][i], r[6][i], r[7][i]};
  }
  // The same of a half space, and of no skin; reads six rows.
  [[gnu::always_inline]] contact::LayerTensor symmetric_at(Sheet::Of of, std::size_t i) const noexcept {
    const auto& r = row[of];
    const double nx = r[1][i], ny = r[2][i];
    return {r[0][i], nx, ny, r[3][i], r[4][i], r[5][i], nx, ny};
  }
  std::array<std::array<const double*, Sheet::kComponents>, Sheet::kRows> row;
};

// What a taxel senses of one contact: pressure and shear, Pa or of a unit dome.
struct Sensed {
  double n = 0, x = 0, y = 0;
};

// Of a pressure and of a shear along (c, s), with the tensor of each.
[[gnu::always_inline]] inline Sensed sensed_of(double p, const contact::LayerTensor& of_p, double q, double c,
                                               double s, const contact::LayerTensor& of_q) noexcept {
  return {p * of_p.nn + q * (c * of_q.nx + s * of_q.ny), p * of_p.xn + q * (c * of_q.xx + s * of_q.xy),
          p * of_p.yn + q * (c * of_q.xy + s * of_q.yy)};
}

// What the slopes of all residuals are made of: both domes' rows, and the unknowns in the form that loops
// take.
struct FieldSlopes {
  FieldRows outer, inner;
  contact::Ellipse wide, narrow;
  double peak, shear, k, rest, dk;  // p0, p0 T/(1 - Gamma), cbrt(Gamma), 1 - Gamma, dk/dGamma
  double c, s;                      // of the pull's direction
  double c2, s2, turn;              // of twice the ellipse's angle; angle by a step across
  double per_size, per_normal, per_shear;
  bool surface;          // no skin: a step of a alone makes a round dome elliptic, too
  bool residuals_given;  // and not computed
  bool symmetric;        // no rigid base
  const double* data;
  double* residuals;
  std::size_t count;
};
// Chooses the loops that this processor can run; else the first frame would.
void choose_field_loops() noexcept;

// Fills the residuals of `by` and their products. unknowns: 8 of a round contact, 10 of an ellipse.
void linearise_field(const FieldSlopes& by, int unknowns, ChannelProducts& products) noexcept;

}  // namespace slipd
