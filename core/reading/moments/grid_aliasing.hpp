// What a regular grid of taxels adds to <r^2> of tractions. Taxels are samples of the traction's mean over
// their squares, and a traction that falls to 0 at a rim has wavelengths shorter than a taxel: by where the
// contact lies on the grid, a sum over taxels misses <r^2> by more than noise (docs/theory.md §5.3). Estimate
// thread; plain state, nothing allocates.
#pragma once

#include <array>
#include <cstddef>

namespace slipd {

class GridAliasing {
 public:
  // side_m: of a taxel; (x_m, y_m): from the middle of any taxel to the contact's centre.
  GridAliasing(double side_m, double x_m, double y_m) noexcept;

  // <r^2> of a dome sqrt(x^2 - r^2), x = radius_m > 0, as a sum over taxels less that of the dome itself and
  // the square's own side^2/6; m^2.
  double of_dome_m2(double radius_m) const noexcept;
  // The same of the shear of a load that only rose: the dome of radius_m less that of the stick zone, for a
  // margin of 0 … 1.
  double of_shear_m2(double radius_m, double gamma) const noexcept;

 private:
  static constexpr std::size_t kHarmonics = 2;
  const double side_m_;
  std::array<double, kHarmonics> weights_;  // of each harmonic of the grid, by the contact's place
};

}  // namespace slipd
