// One frame of a contact whose field a torque has bent (docs/theory.md §10.5, §10.7): by taxels that slip,
// and where none is seen to slip by moments. Says also which frames these are, and which of them show no
// friction. Estimate thread; allocates in its constructor only.
#pragma once

#include "core/estimate/method.hpp"
#include "core/estimate/slipping_taxels.hpp"
#include "core/estimate/turning_load.hpp"
#include "core/estimate/turning_moments.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

class TurningShape {
 public:
  // tracking: frames come in order of time, and memory answers for those that show no friction.
  TurningShape(const TaxelLayout& layout, bool tracking);

  // A new grasp.
  void forget() noexcept;

  // Whether a torque bends this frame's field, or has left traction in it: no method for pulls reads it.
  // Called once for each frame that has a shape.
  bool bent(const TurningLoadResult& load) noexcept;

  // Of a frame that is bent. `loaded` is as SlippingTaxels takes it.
  FrameEstimate estimate(const ContactPatch& loaded, const TurningLoadResult& load) noexcept;

 private:
  bool slips_anew(const FrameEstimate& estimate, double normal_n, const TurningLoadResult& load) noexcept;

  SlippingTaxels slipping_;
  TurningMoments moments_;
  double most_stuck_n_ = 0;  // ratio times P of the plateau, at its most since slip was last seen
  bool tracking_;
  bool bent_ = false;  // a torque's traction is in the contact
};

}  // namespace slipd
