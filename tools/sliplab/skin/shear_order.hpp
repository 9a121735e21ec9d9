// Whether a sensor's shear has the signs and the order of its layout. Taxels under rubber read a press as
// shear that points away from its middle (docs/theory.md §5.4).
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/patch/patch.hpp"

namespace sliplab {

enum class ShearOrderVerdict : std::uint8_t {
  unclear,        // no shear by pressing above noise: taxels at the surface, or too few or too weak presses
  outward,        // as it should be
  x_reversed,     // shear along x has the wrong sign
  y_reversed,     // shear along y has the wrong sign
  both_reversed,  // both have
  transposed,     // x and y are exchanged, of shear or of the layout
  turned          // shear is turned by a quarter against the layout
};
// What to do about it, for people; empty where nothing is to do.
std::string_view advice_on(ShearOrderVerdict verdict) noexcept;

class ShearOrder {
 public:
  // A frame of a press. The patch is of this layout and in contact.
  void add(const slipd::TaxelLayout& layout, const slipd::ContactPatch& patch);

  // Correlations of the shear along x and y with the place along x and y from the contact's middle, each
  // taxel with the weight of its pressure; -1 … 1: xx, xy, yx, yy.
  std::array<double, 4> correlations() const noexcept;
  ShearOrderVerdict verdict() const noexcept;

 private:
  std::array<double, 4> products_{}, noise_{};
  double shear_square_ = 0, place_square_ = 0;
};

}  // namespace sliplab
