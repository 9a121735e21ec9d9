// One frame of a contact whose field a torque has bent (docs/methods.md §27.2, §27.4): by taxels that slip,
// and where none is seen to slip by moments. Says also which frames these are, and which of them show no
// friction. Estimate thread; allocates in its constructor only.
#pragma once

#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/torque/equivalent_pull.hpp"
#include "core/reading/torque/friction_plateau.hpp"
#include "core/reading/torque/torque_moment_ratio.hpp"

namespace slipd {

class TorqueReading {
 public:
  // tracking: frames come in order of time, and memory answers for those that show no friction.
  TorqueReading(const TaxelLayout& layout, bool tracking);

  // A new grasp.
  void forget() noexcept;

  // Whether a torque bends this frame's field, or has left traction in it: no method for pulls reads it.
  // Called once for each frame that has a shape.
  bool bent(const EquivalentPullResult& load) noexcept;

  // Of a frame that is bent. `loaded` is as FrictionPlateau takes it.
  Reading estimate(const ContactPatch& loaded, const EquivalentPullResult& load) noexcept;

 private:
  bool slips_anew(const Reading& estimate, double normal_n, const EquivalentPullResult& load) noexcept;

  FrictionPlateau slipping_;
  TorqueMomentRatio moments_;
  double most_stuck_n_ = 0;  // ratio times P of the plateau, at its most since slip was last seen
  bool tracking_;
  bool bent_ = false;  // a torque's traction is in the contact
};

}  // namespace slipd
