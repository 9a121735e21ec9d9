// The forces that act at the surface of a contact, from what taxels measure of them: at the surface itself,
// under a skin that spreads them, and on a pad of few taxels under a skin. Estimate thread; nothing
// allocates after construction.
#pragma once

#include <optional>
#include <string_view>

#include "core/contact/scene.hpp"
#include "core/estimate/estimate.hpp"
#include "core/frame/layout.hpp"
#include "core/margin/pad_forces.hpp"
#include "core/numeric/posterior_sums.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

struct SurfaceLoad {
  // The contact with the forces that act; shear_n is the equivalent pull of force and torque, N.
  ContactPatch acting;
  // What the margin's lower bound is computed from, N: normal force, shear force without torque, equivalent
  // pull, each with its standard deviation.
  MeanSigma normal_n, shear_n, pull_n;
  // Standard deviation of Q/P beyond noise, relative, that all frames of a grasp have in common.
  double common_sigma = 0;
  // Whether the forces that act are known; else those that are measured are taken for them.
  bool known = true;
};

class SurfaceForces {
 public:
  virtual ~SurfaceForces() = default;
  // Its name among the stages of a pipeline.
  virtual std::string_view name() const noexcept = 0;
  // patch: as measured, with shear. pull: the same with the equivalent pull. Writes the forces that act to
  // `out`.
  virtual SurfaceLoad of(const ContactPatch& patch, const ContactPatch& pull, const Reading& reading,
                         Estimate& out) noexcept = 0;
  // Standard deviation of Q/P beyond noise, relative, that all frames have in common.
  virtual double common_sigma() const noexcept { return 0; }
  // The contact was lost.
  virtual void forget() noexcept = 0;
};

// What is measured is what acts.
SurfaceLoad measured_load(const ContactPatch& patch, const ContactPatch& pull) noexcept;

// Taxels at the surface: a reading may know forces of a contact that the patch's disc reads only a part of
// (an ellipse). Each frame for itself.
class ForcesAtSurface final : public SurfaceForces {
 public:
  std::string_view name() const noexcept override { return "forces_at_surface"; }
  SurfaceLoad of(const ContactPatch& patch, const ContactPatch& pull, const Reading& reading,
                 Estimate& out) noexcept override;
  void forget() noexcept override {}
};

// Taxels under a skin: the disc's share of the forces goes on from frame to frame, and is unknown until a
// first reading has shown it.
class ForcesUnderSkin final : public SurfaceForces {
 public:
  std::string_view name() const noexcept override { return "forces_under_skin"; }
  SurfaceLoad of(const ContactPatch& patch, const ContactPatch& pull, const Reading& reading,
                 Estimate& out) noexcept override;
  void forget() noexcept override { share_.reset(); }

 private:
  struct Share {
    double normal = 1, shear = 1;  // force that acts over the disc's
  };
  std::optional<Share> share_;
};

// Few taxels under a skin: sums over all of them show the forces.
class ForcesOfPad final : public SurfaceForces {
 public:
  ForcesOfPad(const TaxelLayout& layout, const Skin& skin) : pad_(layout, skin) {}
  std::string_view name() const noexcept override { return "forces_of_pad"; }
  SurfaceLoad of(const ContactPatch& patch, const ContactPatch& pull, const Reading& reading,
                 Estimate& out) noexcept override;
  void forget() noexcept override {}
  double common_sigma() const noexcept override { return pad_.ratio_sigma(); }

 private:
  const PadForces pad_;
};

}  // namespace slipd
