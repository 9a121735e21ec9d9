// One frame of a contact whose field a torque has bent (docs/methods.md §27.2, §27.4): by taxels that slip,
// and where none is seen to slip by moments. Says also which frames these are, and which of them show no
// friction. Estimate thread; allocates in its constructor only.
#pragma once

#include "core/frame/layout.hpp"
#include "core/load/equivalent_pull.hpp"
#include "core/load/torque_path.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/torque/friction_plateau.hpp"
#include "core/reading/torque/torque_moment_ratio.hpp"

namespace slipd {

class TorqueReading {
 public:
  virtual ~TorqueReading() = default;
  TorqueReading(const TorqueReading&) = delete;
  TorqueReading& operator=(const TorqueReading&) = delete;

  // A new grasp.
  virtual void forget() noexcept;
  // The same, and it may carry a load already.
  void lose_sight() noexcept;

  // Each frame in contact, first. friction: as far as it is known, > 0.
  void follow(const ContactPatch& patch, const EquivalentPullResult& pull, double friction) noexcept {
    frame_ = {.path = path_.follow(patch, pull, friction)};
  }
  // Whether a torque changes this frame's field, or has left traction in it: no method for pulls reads it.
  // Called once for each frame that has a shape.
  virtual bool torque_changes_shear(const EquivalentPullResult& pull) noexcept {
    return pull.torque_effect == TorqueEffect::changes_shear;
  }
  // Of a frame that is bent. `loaded` is as FrictionPlateau takes it.
  Reading estimate(const ContactPatch& loaded, const EquivalentPullResult& pull) noexcept;

 protected:
  explicit TorqueReading(const TaxelLayout& layout) : slipping_(layout), moments_(layout) {}
  // Whether the plateau of a frame is one of taxels that slip, not of such that stick again.
  virtual bool slips_anew(const Reading& plateau, double normal_n) noexcept = 0;
  const FrictionPlateau& slipping() const noexcept { return slipping_; }
  const TorquePathState& path() const noexcept { return frame_.path; }

 private:
  FrictionPlateau slipping_;
  TorqueMomentRatio moments_;
  TorquePath path_;
  struct ThisFrame {
    TorquePathState path;
  };
  ThisFrame frame_;
};

// Each frame for itself: settings without tracking.
class TorqueReadingOfFrames final : public TorqueReading {
 public:
  explicit TorqueReadingOfFrames(const TaxelLayout& layout) : TorqueReading(layout) {}

 private:
  bool slips_anew(const Reading& /*plateau*/, double /*normal_n*/) noexcept override { return true; }
};

// Memory answers for frames that show no friction.
class TorqueReadingOverTime final : public TorqueReading {
 public:
  explicit TorqueReadingOverTime(const TaxelLayout& layout) : TorqueReading(layout) {}
  void forget() noexcept override;
  bool torque_changes_shear(const EquivalentPullResult& pull) noexcept override;

 private:
  bool slips_anew(const Reading& plateau, double normal_n) noexcept override;

  double most_stuck_n_ = 0;            // ratio times P of the plateau, at its most since slip was last seen
  bool torque_changed_shear_ = false;  // a torque's traction is in the contact
};

}  // namespace slipd
