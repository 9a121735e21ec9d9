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

// Checked with `slipd-lab faults` and on recordings of real sensors.
struct ContinuityOptions {
  // Unlikeness of two frames' pressures (PatternChange) that no contact makes, if it exceeds kBeyondUsual
  // times what late frames and noise make; 0.05 … 0.5. Too small: rolling contacts jump. Too large: another
  // contact's frames are believed.
  double least_unlike = 0.15;
  // The same of frames at most fast_step_s apart; 0.01 … 0.2: less happens in a shorter time. Frames that are
  // less unlike are of one contact: its pressures all changed by kWrongScale are of a wrong unit.
  double least_unlike_fast = 0.02;
  // Shear that turns in one frame (kTurned) does so by at least this share of the normal force, 0.02 … 0.3,
  // in frames at most so long apart; s, 1e-3 … 0.01: what is held has mass. Too small: knocks are called
  // faults. Too large: exchanged axes are believed.
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
  double by_growth(const ContactPatch& patch) const noexcept;
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
