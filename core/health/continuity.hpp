// Whether a clear contact goes on from one frame to the next: another sensor's frames, exchanged or turned
// axes and a wrong unit that begin in mid-grasp change in one frame what a contact changes over many.
// Estimate thread; plain state, nothing allocates.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/health/health.hpp"
#include "core/health/probes.hpp"
#include "core/health/usual.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

// What is wrong by this factor is no contact, but a wrong unit; 5 … 100. Too small: quick grips of flat
// skins, or contacts unlike a sphere, are called faults. Too large: a wrong unit is believed.
inline constexpr double kWrongScale = 30;

// Checked with `slipd-lab faults` and on recordings of real sensors.
struct ContinuityOptions {
  // Frames are compared if the time between them is at most so many usual ones; 1 … 10. Too small: nothing is
  // compared on a busy machine. Too large: what a contact did while frames were lost is called a jump.
  double regular_steps = 2;
  // Unlikeness of two frames' pressures (PatternChange) that no contact makes, if it exceeds kBeyondUsual
  // times what late frames and noise make; 0.05 … 0.5. Too small: rolling contacts jump. Too large: another
  // contact's frames are believed.
  double least_unlike = 0.15;
  // The same of frames at most fast_step_s apart; 0.01 … 0.2: less happens in a shorter time. Frames that are
  // less unlike are of one contact: its pressures all changed by kWrongScale are of a wrong unit.
  double least_unlike_fast = 0.02;
  // For frames further apart than fast_step_s. A contact whose force changes in one frame changes its size as
  // Hertz's theory predicts. The first, 1 … 3, times that change is allowed if the centre moved by less than
  // the second, 0.05 … 0.5, times the radius. Too small: a gripper that closes at once on an alert loses its
  // margin. Too large: another contact of another force at the same place passes.
  double growth_factor = 1.5;
  double growth_moved_share = 0.25;
  // Turn of the shear in one frame; rad, 0.2 … 1.5, by which it changes by at least this share of the normal
  // force, 0.02 … 0.3, in frames at most so long apart; s, 1e-3 … 0.01: what is held has mass. Too small:
  // knocks are called faults. Too large: exchanged axes are believed.
  double least_turn_rad = 0.25;
  double least_turn_share = 0.05;
  double fast_step_s = 3e-3;
};

class Continuity {
 public:
  // A frame that is not believed for another reason: the next one is not compared with it.
  void skip(std::int64_t time_ns) noexcept;

  // Any other frame. A jump lasts until the object is let go: its force is not clear any more, or the
  // kWrongScale-th part of what it was. `probes`: taxels in `pattern`. Returns good,
  // jump or wrong_scale.
  Health update(std::int64_t time_ns, const ContactPatch& patch, const PatternChange& pattern,
                std::size_t probes, const ContinuityOptions& options) noexcept;

 private:
  bool unlike(const ContactPatch& patch, const PatternChange& pattern, std::size_t probes, bool fast,
              const ContinuityOptions& options) noexcept;
  double by_growth(const ContactPatch& patch, const ContinuityOptions& options) const noexcept;
  bool turned(const ContactPatch& patch, const ContinuityOptions& options) noexcept;
  bool scaled(const ContactPatch& patch, const PatternChange& pattern,
              const ContinuityOptions& options) noexcept;

  std::int64_t last_ns_ = 0;  // 0: no frame yet
  double usual_step_s_ = 0;   // between frames; 0: not known
  UsualValue unlikeness_, turn_;
  bool last_clear_ = false, last_directed_ = false;
  double last_normal_n_ = 0, last_noise_pa_ = 0;
  double last_center_x_m_ = 0, last_center_y_m_ = 0, last_radius_m_ = 0;
  double last_shear_x_n_ = 0, last_shear_y_n_ = 0, last_shear_sigma_n_ = 0;
  double broken_at_n_ = 0;    // the normal force at which this contact jumped; 0: it did not
  double scaled_from_n_ = 0;  // the normal force before all pressures were scaled; 0: they were not
};

}  // namespace slipd
