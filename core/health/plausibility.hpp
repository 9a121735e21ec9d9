// Whether a frame can be what the sensor's skin sensed. One monitor a sensor, in front of its estimator: a
// fault of a device must not come out as a safe grip. Single taxels are left out, frames are refused, and a
// channel that died is a fault of the sensor until it lives again. Health names each reason.
//
// What costs a pass over all taxels is measured by PatchFinder in the passes that it makes anyway (the
// frame's extremes). What compares frames looks at probes only. Estimate thread; fixed memory, nothing
// allocates after construction.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/layout.hpp"
#include "core/health/continuity.hpp"
#include "core/health/health.hpp"
#include "core/health/limits.hpp"
#include "core/health/noise_jump.hpp"
#include "core/health/probes.hpp"
#include "core/health/spike_finder.hpp"
#include "core/health/stillness.hpp"
#include "core/health/usual.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

// What is done about it; the later, the graver.
enum class Verdict : std::uint8_t {
  plausible,        // the frame is used
  taxels_left_out,  // the frame is used without some taxels
  frame_refused,    // the frame is not used
  sensor_fault      // the sensor has failed
};

struct Judgement {
  Verdict verdict = Verdict::plausible;
  Health health = Health::good;
  // Of the taxels that are left out.
  std::uint32_t taxels_left_out = 0;
  // The force that they stand for, of the normal force; 0 … 1.
  double left_out_share = 0;
  // Whether the frame is the one before, in all probes, its force and its extremes, and not all 0: a device
  // that is asked more often than it measures.
  bool repeats = false;
};

// Checked with `slipd-lab faults`.
struct PlausibilityOptions {
  // Earlier frames that a frame is compared with.
  static constexpr std::size_t kPast = 64;

  SpikeOptions spikes;
  ContinuityOptions continuity;

  // The contact's centre does not move by more than the contact's radius and this in one frame; sides, 1
  // … 10. Too small: rolling contacts at low rates jump. Too large: another sensor's frames are believed.
  double jump_sides = 3;
  // The least pressure of all taxels does not rise in one frame by this share of the greatest; 0.2 … 1. Too
  // small: grips that press the whole pad at once. Too large: an offset of all taxels is believed.
  double least_rise_share = 0.5;
};

class PlausibilityMonitor {
 public:
  PlausibilityMonitor(const TaxelLayout& layout, const PlausibilityLimits& limits,
                      const PlausibilityOptions& options = {});

  // First call for each frame, with the patch that was found in it. True if taxels are left out: the patch is
  // to be found anew in mended().
  bool screen(const Frame& frame, const ContactPatch& patch) noexcept;

  // The frame that was screened, with neighbours in place of the taxels that are left out. Valid until the
  // next call of screen().
  Frame mended(const Frame& frame) const noexcept { return spikes_.mended(frame); }

  // Second call for each frame, with the patch that is used.
  const Judgement& judge(const Frame& frame, const ContactPatch& patch) noexcept;

 private:
  // What is known of one channel.
  struct Channel {
    Stillness stillness;
    bool alive_in_contact = false;  // it was not 0 since the contact began
    std::uint32_t alive_free = 0;   // frames without contact in which it was not 0
    bool dead = false;
    float last_extreme_pa = 0;  // of the last frame
    float extreme_step_pa = 0;  // its last change
    Stillness extreme;          // whether it repeats
    float rail_pa = 0;          // where it saturates; 0: not known
  };

  void blame(Verdict verdict, Health health) noexcept;
  void judge_values(const ContactPatch& patch) noexcept;
  void judge_size(const ContactPatch& patch) noexcept;
  void judge_time(std::int64_t time_ns) noexcept;
  void judge_offset(const ContactPatch& patch) noexcept;
  bool raised(const ContactPatch& patch) const noexcept;
  void judge_course(const SeenFrame& now) noexcept;
  void judge_continuity(const SeenFrame& now) noexcept;
  bool judge_frozen() noexcept;
  void judge_past() noexcept;
  void blame_repeated(std::uint32_t run) noexcept;
  void judge_channel(std::size_t channel, const ContactPatch& patch) noexcept;
  void judge_lines() noexcept;
  void judge_rail(std::size_t channel, const Frame& frame, const ContactPatch& patch) noexcept;
  static std::size_t count_at(std::size_t channel, float magnitude_pa, const Frame& frame,
                              const ContactPatch& patch) noexcept;
  void learn_change(const ContactPatch& patch) noexcept;
  bool touched_before() const noexcept { return before_ && before_->contact.in_contact; }
  void hold() noexcept;

  TaxelLayout layout_;
  PlausibilityLimits limits_;
  PlausibilityOptions options_;
  SpikeFinder spikes_;
  Probes probes_;
  Continuity continuity_;
  NoiseJump noise_jump_;
  Stillness frame_stillness_;
  std::array<Channel, kChannels> channels_;
  std::vector<Stillness> lines_;
  std::size_t turn_ = 0;      // of the lines that are learnt from
  bool lines_stand_ = false;  // a line did not change in the last frame
  Judgement now_;
  Judgement held_;              // the last fault
  std::uint32_t good_run_ = 0;  // frames since the last fault
  std::size_t spikes_found_ = 0;
  static constexpr std::uint32_t kNever = std::numeric_limits<std::uint32_t>::max();
  std::array<std::uint64_t, PlausibilityOptions::kPast> past_{};  // fingerprints of the last frames, a ring
  std::size_t next_past_ = 0;
  std::uint32_t since_repeat_ = kNever;  // frames
  std::uint32_t past_run_ = 0;           // frames in a row that were there before
  bool sensed_ = false;                  // a probe of this frame is not 0
  std::optional<SeenFrame> before_;      // none: this is the first
  UsualValue change_;                    // of the normal force in a frame, share, in this contact
  float lifted_pa_ = 0;                  // half of what all taxels have risen to at once; 0: they have not
  double fallen_from_n_ = 0;  // the normal force fell from this to nothing in one frame; 0: it did not
};

}  // namespace slipd
