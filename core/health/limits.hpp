// What a sensor can read at all, and what its skin can carry: the bounds that frames are held against.
#pragma once

#include "core/frame/layout.hpp"

namespace slipd {

// The largest magnitudes that a sensor can read, Pa; above 0.
struct FullScale {
  double normal_pa = 0;
  double shear_x_pa = 0;
  double shear_y_pa = 0;
  bool operator==(const FullScale&) const = default;
};

// Of a sensor for which nothing is configured: beyond what any of its class reads. Arrays 20 MPa (forty times
// the modulus of a soft skin), wrenches 5 kN over the pad's area.
FullScale default_full_scale(SensorClass sensor_class, const TaxelLayout& layout) noexcept;

struct PlausibilityLimits {
  FullScale full_scale;
  // a^3/P = 3 R/(4 E*) of the stiffest and the softest contact that the scene expects, m^3/N (docs/theory.md
  // §2); 0: not known, and sizes are not compared with forces.
  double least_m3_per_n = 0;
  double greatest_m3_per_n = 0;
  // A skin without curvature: a contact may press all taxels in one frame.
  bool flat = false;
};

}  // namespace slipd
