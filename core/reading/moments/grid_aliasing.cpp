#include "core/reading/moments/grid_aliasing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slipd {

GridAliasing::GridAliasing(double side_m, double x_m, double y_m) noexcept : side_m_(side_m) {
  const double cos_x = std::cos(2 * std::numbers::pi * x_m / side_m),
               cos_y = std::cos(2 * std::numbers::pi * y_m / side_m);
  const double first = 3 * side_m * side_m / (std::numbers::pi * std::numbers::pi);
  weights_ = {-first * (cos_x + cos_y), first / 4 * (2 * cos_x * cos_x + 2 * cos_y * cos_y - 2)};
}

// j0 and j1 are the spherical Bessel functions; the dome's transform is 3 j1(z)/z of its volume.
double GridAliasing::of_dome_m2(double radius_m) const noexcept {
  constexpr double kNoRadius = 1e-3;  // of z: below it the quotients lose their digits, and the limit holds
  const double z1 = 2 * std::numbers::pi * radius_m / side_m_;
  if (z1 < kNoRadius) return (weights_[0] + weights_[1]) / 3;
  const double sine = std::sin(z1), cosine = std::cos(z1);
  const auto harmonic = [](double z, double sin_z, double cos_z) {
    const double j0 = sin_z / z, j1 = (j0 - cos_z) / z;
    return 4 * j1 / z - j0;
  };
  return weights_[0] * harmonic(z1, sine, cosine) +
         weights_[1] * harmonic(2 * z1, 2 * sine * cosine, 1 - 2 * sine * sine);
}

double GridAliasing::of_shear_m2(double radius_m, double gamma) const noexcept {
  constexpr double kNoLoad = 1e-3;  // of 1 - Gamma: the difference of two domes becomes a derivative
  const double sticks = std::min(gamma, 1 - kNoLoad);
  return (of_dome_m2(radius_m) - sticks * of_dome_m2(radius_m * std::cbrt(sticks))) / (1 - sticks);
}

}  // namespace slipd
