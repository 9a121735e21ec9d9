// The forces on a pad of few taxels under a skin, by the sums over all of them. What reaches a plane under
// the skin carries the whole load, whatever the contact's shape and history. A pad reads a part of it, which
// follows from where the pressure is and how deep the taxels are (docs/methods.md §29.6). Estimate thread;
// nothing allocates after construction.
#pragma once

#include <optional>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/contact/subsurface/point_load.hpp"
#include "core/contact/subsurface/rigid_base.hpp"
#include "core/contact/subsurface/subsurface_point.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

// Checked with `slipd-lab histories --sides 4 --skin-mm 1 --friction value`.
struct PadForcesOptions {
  // The part of a pull that a pad has to read for its forces to be known; 0.2 … 0.8. Too small: contacts at
  // the edge get margins from a tail of their shear. Too large: small pads get none.
  double least_read = 0.4;
};

class PadForces {
 public:
  // skin: of a depth above 0.
  PadForces(const TaxelLayout& layout, const Skin& skin, const PadForcesOptions& options = {});

  // Forces that act, N, and their standard deviations by noise.
  struct Forces {
    double normal_n = 0;
    double shear_x_n = 0, shear_y_n = 0;
    double normal_sigma_n = 0, shear_sigma_n = 0;
    // The part of a pull that the pad reads, 0 … 1.
    double read = 1;
  };
  // None where the pad reads too little of them, or no pressure. fitted: of this frame, or empty. Its noise
  // counts where it is more than the patch's: under a skin hardly a taxel reads a negative pressure, that a
  // single frame's noise would show by.
  std::optional<Forces> of(const ContactPatch& patch, const Reading& fitted = {}) const noexcept;

  // Standard deviation of Q/P beyond noise, relative: by the depth, as far as it is known, and by the shape.
  // Frames of a grasp have it in common.
  double ratio_sigma() const noexcept { return ratio_sigma_; }

 private:
  // Of a frame: sums over all taxels, N, and centre and mean square radius of the pressure that is read, m.
  struct Sums {
    double normal_n = 0, shear_x_n = 0, shear_y_n = 0;
    double x_m = 0, y_m = 0, squares_m2 = 0;
    bool pressed = false;
  };
  Sums sums_of(const ContactPatch& patch) const noexcept;
  double missed_sigma(double depth_sigma) const noexcept;
  // By all taxels, of a load of 1 N that is spread about a place, with this root mean square distance.
  contact::LayerTensor read_of(double x_m, double y_m, double spread_m) const noexcept;

  const PadForcesOptions options_;
  const TaxelLayout layout_;
  const double depth_m_;
  const std::vector<contact::LayerImage> images_;  // none: a half space
  const std::vector<contact::Rectangle> parts_;    // of the pad
  const double ratio_sigma_;
};

}  // namespace slipd
