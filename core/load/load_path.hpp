// Where the load of a contact goes: what acts now, and a frame ago. Estimate thread; fixed memory, nothing
// allocates.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/numeric/norm.hpp"
#include "core/numeric/posterior_sums.hpp"
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

// Of a frame in contact.
struct Load {
  // CLOCK_MONOTONIC, ns.
  std::int64_t time_ns = 0;
  ContactForces measured;
  // That acts on friction: P, and the pull that asks for as much of it as force and torque together, N.
  double normal_n = 0, pull_n = 0;
  // Standard deviation of its pull over P.
  double ratio_sigma = 0;
  // A torque has changed the field of shear.
  bool under_torque = false;

  // |Q|/P.
  MeanSigma ratio() const noexcept { return {pull_n / normal_n, ratio_sigma}; }
};

// acting: `measured` with the forces that act, and the equivalent pull in shear_n.
inline Load load_of(std::int64_t time_ns, const ContactPatch& measured, const ContactPatch& acting,
                    bool under_torque) noexcept {
  const double ratio = acting.shear_n / acting.normal_n;
  return {.time_ns = time_ns,
          .measured = forces_of(measured),
          .normal_n = acting.normal_n,
          .pull_n = acting.shear_n,
          .ratio_sigma = norm(acting.shear_sigma_n, ratio * acting.normal_sigma_n) / acting.normal_n,
          .under_torque = under_torque};
}

// From one frame in contact to the next.
struct LoadStep {
  Load now;
  // A frame ago; none: this is the first frame of the contact.
  std::optional<Load> previous;

  // A frame ago; in the first frame no load.
  Load before() const noexcept { return previous.value_or(Load{}); }
  // How far the measured shear moved since then, N; all of it in the first frame.
  double shear_moved_n() const noexcept {
    const ContactForces to = now.measured, from = before().measured;
    return norm(to.shear_x_n - from.shear_x_n, to.shear_y_n - from.shear_y_n);
  }
  // Since then, s, >= 0; 0 in the first frame.
  double seconds() const noexcept {
    constexpr double kSecondsPerNs = 1e-9;
    return previous ? std::max(0.0, kSecondsPerNs * static_cast<double>(now.time_ns - previous->time_ns)) : 0;
  }
};

class LoadPath {
 public:
  // The contact was lost.
  void forget() noexcept { last_.reset(); }

  // Each frame in contact, in order of time.
  LoadStep follow(const Load& now) noexcept { return {now, std::exchange(last_, now)}; }

 private:
  std::optional<Load> last_;
};

}  // namespace slipd
