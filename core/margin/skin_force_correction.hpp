// The forces that act on a contact where the patch's disc reads only a part of them: under a skin, and of
// ellipses. Estimate thread; nothing allocates.
#pragma once

#include <optional>

#include "core/estimate/estimate.hpp"
#include "core/margin/pad_forces.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

class SkinForceCorrection {
 public:
  // Under a skin, how fast the disc's share of the forces follows what a frame shows of it; 0.02 … 1. Too
  // small: it lags behind a contact that grows. Too large: noise of single frames moves the forces.
  static constexpr double kGain = 0.2;

  // under_skin: the disc's share goes on from frame to frame. Else each frame has its own.
  explicit SkinForceCorrection(bool under_skin) noexcept : under_skin_(under_skin) {}

  // The contact was lost.
  void forget() noexcept { share_.reset(); }

  // Whether the forces that act are known; else those of the disc are taken for them.
  bool known() const noexcept { return share_.has_value(); }

  // `loaded` with the forces that act, which are written to `out` as well. patch: as it was read, with shear.
  // loaded: the same with the pull that stands for force and torque.
  ContactPatch of(const ContactPatch& patch, const ContactPatch& loaded, const Reading& reading,
                  Estimate& out) noexcept;
  // The same of a pad of few taxels, whose sums show them; nullopt: they are not known.
  ContactPatch of_pad(const std::optional<PadForces::Forces>& forces, const ContactPatch& patch,
                      const ContactPatch& loaded, Estimate& out) noexcept;

 private:
  struct Share {
    double normal = 1, shear = 1;  // force that acts over the disc's
  };
  bool under_skin_;
  std::optional<Share> share_;
};

}  // namespace slipd
