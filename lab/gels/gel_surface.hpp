// How the surface of a gel moves that is bonded to a rigid base, under tractions on a disc: an elastic layer,
// exactly, by Fourier and Hankel transforms (the same solution as finite_elements/layer.py, which
// CalculiX was compared with).
#pragma once

#include <array>
#include <vector>

namespace lab {

class GelSurface {
 public:
  // thickness_m: > 0; poisson: 0 … 0.49.
  GelSurface(double thickness_m, double poisson);

  // Along the drag, and across it.
  struct Moved {
    double along_m = 0, across_m = 0;
  };
  // Of the surface at (x, y) from the disc's centre, under a shear traction along x of sqrt(1 - (r/radius)^2)
  // shear moduli.
  Moved dragged(double radius_m, double x_m, double y_m) const noexcept;
  // Away from the centre, at a distance r of it, under such a pressure; m.
  double pressed(double radius_m, double r_m) const noexcept;

 private:
  // By wave number: what a wave of traction moves in its own direction, across it, and in its direction by
  // pressure; over the shear modulus.
  struct Wave {
    double along = 0, across = 0, pressed = 0;
  };
  Wave wave(double number_per_m, double poisson) const;

  // Hankel transforms of orders 0, 2 and 1, of one radius over the distance.
  struct Values {
    double even = 0, twofold = 0, radial = 0;
  };
  static constexpr int kRadii = 28, kDistances = 80;
  static constexpr double kRadiusStep_m = 0.25e-3, kDistanceStep_m = 0.25e-3;
  Values at(double radius_m, double r_m) const noexcept;

  double thickness_m_;
  std::array<std::array<Values, kDistances + 1>, kRadii> table_{};
};

}  // namespace lab
