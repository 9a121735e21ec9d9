// Whether a clear contact goes on from one frame to the next: another sensor's frames, exchanged or turned
// axes and a wrong unit that begin in mid-grasp change in one frame what a contact changes over many.
// Estimate thread; plain state, nothing allocates.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/health/health.hpp"
#include "core/health/probes.hpp"
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
  // Memory of what is usual; of half as many clear frames on something is said; frames, 16 … 1000. Too small:
  // chance. Too large: the beginning of a quick motion is called a jump.
  std::uint32_t memory_frames = 32;
  std::uint32_t learning_frames() const noexcept { return memory_frames / 2; }
  // Unlikeness of two frames' pressures (PatternChange) that no contact makes: at least this, 0.05 … 0.5, and
  // beyond what noise makes by a factor, 2 … 100. Too small: rolling contacts jump. Too large: another
  // contact's frames are believed.
  double least_unlike = 0.15;
  // The same of frames at most fast_step_s apart; 0.01 … 0.2: less happens in a shorter time.
  double least_unlike_fast = 0.02;
  double noise_factor = 4;
  // Beyond the largest of late frames, forgotten with memory_frames, by this factor, 1.5 … 10: while an
  // object slides over a sensor of few taxels, the pressures change more from frame to frame, but do not
  // jump. Too small: slides are called jumps. Too large: another contact's frames are believed if the last
  // one moved.
  double peak_factor = 3;
  // For frames further apart than fast_step_s. A contact whose force changes in one frame changes its size as
  // Hertz's theory predicts. The first, 1 … 3, times that change is allowed if the centre moved by less than
  // the second, 0.05 … 0.5, times the radius. Too small: a gripper that closes at once on an alert loses its
  // margin. Too large: another contact of another force at the same place passes.
  double growth_factor = 1.5;
  double growth_moved_share = 0.25;
  // All pressures changed by kWrongScale, though less unlike than this; 0.01 … 0.2. A contact that carries
  // more grows. Too small: a wrong unit is believed. Too large: quick grips of flat skins.
  double same_pattern = 0.05;
  // Turn of the shear in one frame; rad, 0.2 … 1.5, by which it changes by at least this share of the normal
  // force, 0.02 … 0.3, in frames at most so long apart; s, 1e-3 … 0.01: what is held has mass. Too small:
  // knocks are called faults. Too large: exchanged axes are believed.
  double least_turn_rad = 0.25;
  double least_turn_share = 0.05;
  double fast_step_s = 3e-3;
  // A contact that jumped is let go when its force is below this share of what it was then, or not clear;
  // 0.01 … 0.5. Too small: a sensor that always reads some force has no margin any more. Too large: a grip
  // that loosens has one again, though its contact is not known.
  double let_go_share = 0.1;
};

// Mean of a quantity that is small while a contact goes on, and the largest of late.
struct UsualValue {
  double mean = 0;
  double peak = 0;
  std::uint32_t frames = 0;  // that it is of, at most memory_frames
  void learn(double value, std::uint32_t memory_frames) noexcept;
};

class Continuity {
 public:
  // A frame that is not believed for another reason: the next one is not compared with it.
  void skip(std::int64_t time_ns) noexcept;

  // Any other frame. A jump lasts until the object is let go. `probes`: taxels in `pattern`. Returns good,
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
