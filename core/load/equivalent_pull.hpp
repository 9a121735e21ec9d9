// The pull without torque that needs as much friction as force and torque of a contact together
// (docs/theory.md §6.6): what compares |Q|/P with friction then holds for a contact that turns, too. Without
// a torque above noise it is Q itself.
#pragma once

#include <cstdint>
#include <memory>

#include "core/contact/limit_surface.hpp"
#include "core/frame/layout.hpp"
#include "core/frame/model_errors.hpp"
#include "core/patch/patch.hpp"
#include "core/patch/pressure_cells.hpp"

namespace slipd {

// What square taxels make of the torque, of Q a, and of the ratio of its moments, over (side/a)^2; 0 … 0.3.
// Too small: pure pulls get torques, and sigma is less than the error on coarse arrays. Too large: small
// torques are left out of margins, and coarse arrays are refused.
inline constexpr double kCoarseTorque = 0.1;

// T: torque, Q: shear force, a: contact radius. A torque below kUnevenShare and kCoarseTorque of Q a is none:
// it changes the margin by less than 2.5 of its squares (§6.6). Checked with
// tests/core/load/equivalent_pull_test.cpp.
struct EquivalentPullOptions {
  // A torque of more than this share of Q a, on few taxels, where noise is a large part of it, counts from
  // kAlikeSigmas on, and until then sigma has what it would add to the pull; 0.2 … 2. Elsewhere it has to be
  // clear. Too small: noise lowers margins. Too large: small torques are left out of margins.
  double outweighing_share = 0.4;
  // What taxels that are cells themselves miss of the torque within them, of T, over (side/a)^2; 0 … 0.3,
  // measured on contacts that slide about any centre. Too small: margins of coarse arrays are too safe. Too
  // large: too low.
  double within_taxels = 0.13;
  // Standard deviation of the pull by what coarse taxels leave open of the torque and its lever, over
  // (side/a)^2, at most 1, of what the torque adds to the pull; 0 … 0.3. Measured with `slipd-lab torque` on
  // 4 x 4 taxels. Too small: sigma is less than the error. Too large: it is more.
  double coarse_sigma_share = 0.2;
};

enum class TorqueEffect : std::uint8_t {
  none,           // noise may be all of the torque
  light,          // it counts for the margin, and leaves the field as it is under a pull
  changes_shear,  // the field is no longer that of a pull
};

struct EquivalentPullResult {
  TorqueEffect torque_effect = TorqueEffect::none;
  // The pull without torque that is as near to slip, N, and its standard deviation; |Q| and its own where
  // torque_effect is none.
  double pull_n = 0, pull_sigma_n = 0;
  // The motion in which the object would slide: its speed along the pull and its spin, for a power of
  // friction P t = 1: derivatives of t = pull_n/P by force and torque; 1/N and 1/(N m), the spin with the
  // torque's sign. 0 where turning is none.
  double along_per_n = 0, spin_per_nm = 0;
};

// Estimate thread; allocates in constructors only.
class EquivalentPull {
 public:
  virtual ~EquivalentPull() = default;
  EquivalentPull(const EquivalentPull&) = delete;
  EquivalentPull& operator=(const EquivalentPull&) = delete;

  // `patch` is in contact. previous: of the frame before in this grasp, `none` for the first one. A field
  // that a torque has changed stays so whatever the noise of the torque.
  EquivalentPullResult of(const ContactPatch& patch, TorqueEffect previous) noexcept;

 protected:
  // side_m: of a taxel; 0 where the torque is measured as a whole.
  EquivalentPull(double side_m, const EquivalentPullOptions& options) : options_(options), side_m_(side_m) {}
  // A taxel's side over the contact's radius.
  double coarse(const ContactPatch& patch) const noexcept { return side_m_ / patch.radius_m; }
  // Whether noise that is an unlikely torque would be most of the load, if it were one.
  virtual bool outweighs(const ContactPatch& /*patch*/) const noexcept { return false; }
  virtual contact::LeastFriction least_friction(const ContactPatch& patch) noexcept = 0;

  const EquivalentPullOptions options_;
  const double side_m_;

 private:
  bool clear(const ContactPatch& patch) const noexcept;
  bool changes_shear(const ContactPatch& patch, bool changed) const noexcept;
};

// A sensor of one force and its torque: in patch.torque_nm, and the contact's radius in patch.radius_m, if
// both are known; its pressure is taken for Hertz's.
class PullOfOneForce final : public EquivalentPull {
 public:
  explicit PullOfOneForce(const EquivalentPullOptions& options = {});

 private:
  contact::LeastFriction least_friction(const ContactPatch& patch) noexcept override;

  const contact::LimitSurface unit_hertz_;
};

// Taxels, whose pressures say where friction is carried.
class PullOfTaxels : public EquivalentPull {
 public:
  explicit PullOfTaxels(const TaxelLayout& layout, const EquivalentPullOptions& options = {});

 private:
  contact::LeastFriction least_friction(const ContactPatch& patch) noexcept override;

  PressureCells cells_;
};

class PullOfFewTaxels final : public PullOfTaxels {
 public:
  using PullOfTaxels::PullOfTaxels;

 private:
  bool outweighs(const ContactPatch& patch) const noexcept override;
};

std::unique_ptr<EquivalentPull> make_equivalent_pull(const TaxelLayout& layout,
                                                     const EquivalentPullOptions& options = {});

}  // namespace slipd
