// The pull without torque that needs as much friction as force and torque of a contact together
// (docs/theory.md §6.6): what compares |Q|/P with friction then holds for a contact that turns, too. Without
// a torque above noise it is Q itself. Estimate thread; allocates in its constructor only.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/contact/limit_surface.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"
#include "core/patch/pressure_cells.hpp"

namespace slipd {

// T: torque, Q: shear force, a: contact radius. Checked with
// tests/core/reading/torque/equivalent_pull_test.cpp.
struct EquivalentPullOptions {
  // A torque above this many standard deviations is one; 2 … 5. Too small: noise lowers margins. Too large:
  // small torques are left out of margins.
  double clear_sigmas = 3;
  // The same on at most few_taxels taxels, more than one, where noise is a large part of a torque, for one of
  // more than outweighing_share of Q a; 1 … 3, 2 … 64, 0.2 … 2. Below it sigma has what the torque would add
  // to the pull. Too small and too large: as above.
  double outweighing_sigmas = 1.5;
  std::size_t few_taxels = 40;
  double outweighing_share = 0.4;
  // And above this share of Q a; 0.001 … 0.05. Below, it changes the margin by less than 2.5 of its squares
  // (§6.6), and square taxels may be all of it. Too small: pure pulls get torques. Too large: as above.
  double least_share = 0.02;
  // What coarse taxels add to that share, over (side/a)^2; 0 … 0.3. Too small and too large: as above, on few
  // taxels.
  double coarse_share = 0.1;
  // Above this share of Q a the shear is no sum of disc terms, and no method for pulls reads it; 0.02 … 0.3.
  // Too small: frames that still are as under a pull go to the method for torque. Too large: margins and
  // friction of pulls are given for fields that torque has changed.
  double bending_share = 0.1;
  // And above this many standard deviations before it has bent the field; 4 … 10. Too small: in light
  // contacts and without a pull noise bends the field, and the load's history is lost. Too large: as above.
  double bending_sigmas = 6;
  // What taxels that are cells themselves miss of the torque within them, of T, over (side/a)^2; 0 … 0.3,
  // measured on contacts that slide about any centre. Too small: margins of coarse arrays are too safe. Too
  // large: too low.
  double within_taxels = 0.13;
  // Standard deviation of the pull by what coarse taxels leave open of the torque and its lever, over
  // (side/a)^2, at most 1, of what the torque adds to the pull; 0 … 0.3. Measured with `slipd-lab torque` on
  // 4 x 4 taxels. Too small: sigma is less than the error. Too large: it is more.
  double coarse_sigma_share = 0.2;
  // A load below this share of its maximum has fallen; 0.8 … 0.99. Too small: fields that slipped before and
  // stick now are read as slipping. Too large: noise of a load that rises is taken for a fall.
  double risen_share = 0.97;
  // While it was above, the share below which it is not any more, of bending_share; 0.5 … 1.
  double kept_share = 0.8;
  // The load path is followed in steps of this share of the load, above this share of the load's maximum;
  // 0.02 … 0.3, 0.2 … 0.8. Too small: noise bends the path. Too large: bends are not detected.
  double step_share = 0.1;
  double followed_share = 0.5;
  // The path is straight while the sum of its steps across the load is at most this share of the load; 0.03 …
  // 0.3. Too small: few paths are straight. Too large: other histories are read as a load that only rose.
  double straight_share = 0.12;
  // And while the normal force is above the reference grip by at most this share, and the load is at least
  // this share of its maximum; 0.005 … 0.05, 0.95 … 0.995. Too strict: noise is taken for a regrip, or for a
  // fall. Too lax: a rim whose slip has reversed is read as a load near slip.
  double tightened_share = 0.015;
  double rising_share = 0.99;
  // A load this many times the largest one at the reference grip makes the present grip the reference; 1.5 …
  // 5. Too small: regrips pass. Too large: after a light touch while the gripper closes, every grip is taken
  // for a regrip.
  double grown = 3;
  // What sticks bears its least load within this share of P, and so many standard deviations of the pull;
  // 0.01 … 0.1, 1 … 4. Too small: noise is taken for a trace of an earlier load. Too large: such traces are
  // read as friction.
  double stuck_share = 0.05;
  double stuck_sigmas = 2;
};

enum class Turning : std::uint8_t {
  none,     // noise may be all of the torque
  light,    // it counts for the margin, and leaves the field as it is under a pull
  bending,  // the field is no longer that of a pull
};

struct EquivalentPullResult {
  Turning turning = Turning::none;
  // The pull without torque that is as near to slip, N, and its standard deviation; |Q| and its own where
  // turning is none.
  double pull_n = 0, pull_sigma_n = 0;
  // Whether force and torque are at their maximum in this grasp: else taxels that slipped may stick again, at
  // ratios below friction.
  bool risen = true;
  // Whether force and torque rose in a straight line at a constant grip since the contact began, and are at
  // their maximum.
  bool straight = true;
  // Whether what sticks bears its least load in this grasp, P - Q'/mu for the pull Q': then the slip annulus
  // goes over all traces of earlier loads. Not so in a grip that was tightened, until the load has grown as
  // well.
  bool least_stuck = true;
  // The motion in which the object would slide: its speed along the pull and its spin, for a power of
  // friction P t = 1: derivatives of t = pull_n/P by force and torque; 1/N and 1/(N m), the spin with the
  // torque's sign. 0 where turning is none.
  double along_per_n = 0, spin_per_nm = 0;
};

class EquivalentPull {
 public:
  explicit EquivalentPull(const TaxelLayout& layout, const EquivalentPullOptions& options = {});

  // A new grasp.
  void reset() noexcept {
    bent_ = false;
    most_ = {};
    way_ = {};
    least_stuck_ = {};
  }

  // After reset(), if a load may be there already: its way is not known, and not straight, until reset().
  void lose_way() noexcept {
    way_.across = std::numeric_limits<double>::infinity();
    way_.straight = false;
  }

  // `patch` is in contact. A sensor of one taxel has the torque in patch.torque_nm and the contact's radius
  // in patch.radius_m, if both are known; its pressure is taken for Hertz's. `friction`: as far as it is
  // known, > 0; which load is the least that sticks depends on it where the grip has changed.
  EquivalentPullResult of(const ContactPatch& patch, double friction) noexcept;

 private:
  EquivalentPullResult weigh(const ContactPatch& patch) noexcept;
  bool sticks_least(const ContactPatch& patch, const EquivalentPullResult& load, double friction) noexcept;
  bool clear(const ContactPatch& patch) const noexcept;
  bool outweighs(const ContactPatch& patch) const noexcept;
  contact::LeastFriction least_friction(const ContactPatch& patch) noexcept;
  void follow(const ContactPatch& patch, EquivalentPullResult& out) noexcept;
  void follow_way(const ContactPatch& patch, double load_n, double noise_n) noexcept;

  EquivalentPullOptions options_;
  PressureCells cells_;
  contact::LimitSurface unit_hertz_;
  double side_m_;
  bool one_taxel_, few_taxels_;
  bool bent_ = false;  // the last frame's field was
  // The most load of this grasp, less what noise may be of it. The contact's radius, and with it the lever
  // that makes a force of the torque, changes with the grip: so both parts are kept.
  struct Most {
    double shear_n = 0, torque_nm = 0;
  };
  Most most_;
  // A point of the load path: force over P along both axes and torque over P a.
  using LoadPoint = std::array<double, 3>;
  struct Way {
    LoadPoint last{};     // where the last step ended
    double across = 0;    // lengths across the load, summed over the steps
    double normal_n = 0;  // least P that counts, 0: there was no load
    double load_n = 0;    // the most load at this grip, N
    bool straight = true;
  };
  Way way_;
  // The frame at which what sticks bore the least.
  struct Stuck {
    double normal_n = 0, pull_n = 0;
  };
  Stuck least_stuck_;
};

}  // namespace slipd
