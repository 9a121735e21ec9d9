// Where the load of a contact goes: its forces now and a frame ago. Estimate thread; fixed memory, nothing
// allocates.
#pragma once

#include <cmath>
#include <optional>

#include "core/numeric/norm.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

// A grip, or a load, that has grown by this factor is another one: what a lighter touch showed, as the
// gripper closed, says nothing of it; 1.2 … 5: a touch may hook, and its zero is a larger part of it. Too
// small: a regrip forgets friction and its history. Too large: the first touch counts for long.
inline constexpr double kGrown = 2;

// A load below this share of its highest has fallen; 0.7 … 1. Too small: a hold at a part of the load passes
// for a slide, and a fall is seen late. Too large: friction that fell a little is not learnt from its slide,
// and a load that turns is taken for a fall.
inline constexpr double kFallen = 0.9;

// Shear across the direction that it had, as a share of it, at which it has turned; 0.1 … 0.9. Too small:
// noise of a small shear ends a history that is known, and slides along a curve are missed. Too large: a
// history along the old axis is believed in vain, and a load that turns is a slide.
inline constexpr double kTurned = 0.3;

// Pull over P from which on something pulls, unless noise explains more; 0.01 … 0.1. Too small: noise pulls,
// and a sensor that reads shear under a normal load never shows pressing alone. Too large: a slow pull passes
// for pressing.
inline constexpr double kPulled = 0.03;

// A load has changed when it moved by this share of P; 0.01 … 0.2. Too small: noise, shaking and relaxation
// change it. Too large: closing counts as a hold, and shear of pressing passes for a pull, or hides a slide
// at a low friction.
inline constexpr double kChanged = 0.05;

// Part of a field that slips, or moves alike, from which on all of it does; 0.7 … 0.95. Slides of real
// pillars have 0.90 to 0.98, grips that relax mostly less than 0.85. Too small: parts that stick again, and
// grips that relax, pass for slides. Too large: slides under a torque or a skin are missed.
inline constexpr double kWhole = 0.85;

// Of a frame, as its taxels measure them.
struct ContactForces {
  double normal_n = 0;                  // P, N
  double shear_x_n = 0, shear_y_n = 0;  // N
};

inline ContactForces forces_of(const ContactPatch& patch) noexcept {
  return {patch.normal_n, patch.shear_x_n, patch.shear_y_n};
}

// From one frame in contact to the next.
struct LoadStep {
  ContactForces now;
  // A frame ago; none: this is the first frame of the contact.
  std::optional<ContactForces> previous;

  // How far the shear moved since then, N; all of it in the first frame.
  double shear_moved_n() const noexcept {
    const ContactForces from = previous.value_or(ContactForces{});
    return norm(now.shear_x_n - from.shear_x_n, now.shear_y_n - from.shear_y_n);
  }
};

class LoadPath {
 public:
  // The contact was lost.
  void forget() noexcept { last_.reset(); }

  // Each frame in contact, in order of time.
  LoadStep follow(const ContactPatch& patch) noexcept {
    const LoadStep step{forces_of(patch), last_};
    last_ = step.now;
    return step;
  }

 private:
  std::optional<ContactForces> last_;
};

}  // namespace slipd
