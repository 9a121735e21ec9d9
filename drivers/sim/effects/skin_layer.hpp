// Taxels under rubber. A force on the surface of an elastic half space is sensed at depth d as the traction
//     t = 3 d (F . R) R / (2 pi |R|^5),   R from the force down to the taxel
// on the plane of the taxels, whatever Poisson's ratio (Boussinesq 1885, Cerruti 1882; Johnson, Contact
// Mechanics, 1985, 3.2 and 3.6). So forces are spread over taxels, pressing alone is sensed as shear that
// points outwards, and a pull as pressure ahead of it and suction behind.
#pragma once

#include <span>
#include <vector>

#include "core/frame/layout.hpp"

namespace slipd::sim {

class SkinLayer {
 public:
  // Forces at (x_m, y_m) on the surface; taxels at depth_m below, > 0.
  SkinLayer(const TaxelLayout& layout, std::span<const double> x_m, std::span<const double> y_m,
            double depth_m);

  // Scales normal and tangential tractions, as the maker's calibration does, so that an even load over all
  // forces is sensed whole: what a pad of finite size does not sense of its edges, is made up for.
  void calibrate(double taxel_area_m2) noexcept;

  // What the taxels sense, Pa, of forces in N: pressing, and along x. The spans have the sizes of the forces
  // and of the layout.
  void sense(std::span<const double> normal_n, std::span<const double> shear_n, std::span<float> normal_pa,
             std::span<float> shear_x_pa, std::span<float> shear_y_pa) const noexcept;

 private:
  // Traction in Pa for 1 N.
  struct Influence {
    float normal_of_normal, normal_of_shear, x_of_normal, x_of_shear, y_of_normal, y_of_shear;
  };
  std::size_t forces_;
  std::vector<Influence> influence_;  // of all forces on the first taxel, then on the second …
};

}  // namespace slipd::sim
