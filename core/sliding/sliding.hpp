// Whether the object slides now, along or turning. It needs no friction and no newtons, and where there is no
// zero, none of that either: the pattern of the taxels stays put while a contact sticks and moves when it
// slides (docs/methods.md §30).
//
// With a zero: the pattern of pressure, each cell's share p/P, is compared with that of up to 0.4 s before. A
// gripper's closing, its overshoot and its relaxation scale P and leave the shares, once the contact has
// settled; so it is looked at from then on only.
//
// Without a zero there are no shares. There the readings' course is looked at: vibration and jolts of a held
// object go to and fro, and a slide goes on. A steady pull at an object that sticks looks the same.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/sliding/taxel_blocks.hpp"

namespace slipd {

enum class Sliding : std::uint8_t {
  none,         // nothing moves
  disturbed,    // the load changed: pulled, pushed, moved, gripped; nothing says that it slid
  translation,  // it slides along
  rotation      // it turns
};

std::string_view to_string(Sliding) noexcept;  // "none", "disturbed", …

// Whether it slides, in one of the two ways.
constexpr bool slides(std::optional<Sliding> sliding) noexcept {
  return sliding && *sliding >= Sliding::translation;
}

// Taxels that carry more than this of P against each other, share, 0.05 … 0.5, take the margin away and show
// no friction: the object is turned, hooked, or pulled at in several places, and the margin of the sum is too
// safe. Quiet grasps of real pillars reach 0.066; a round contact that slipped and was unloaded has 0.45 mu
// of P locked in (docs/theory.md §4.1). Too small: margins come and go. Too large: such a grip is called
// safe.
inline constexpr double kMaxInternalShare = 0.25;

// How the field of shear has gone since the contact settled. Of blocks (core/sliding/taxel_blocks.hpp).
struct FieldCourse {
  // Whether there is a field: enough cells, a zero, a contact and a block of it. Else nothing below counts.
  bool known = false;
  // |sum q|/sum|q|, noise taken off; 0 … 1: 1 where all cells are sheared one way, as by an object that
  // slides. Of what changed since the contact settled, if that is more: the rest is from pressing.
  double coherence = 1;
  // What cells carry against each other, over P, >= 0: of the change of shear since the contact settled, the
  // part that cancels in the sum. Shear that pressing alone makes grows with P and is not in it. 0 before the
  // contact has settled.
  double internal_share = 0;
  // Whether the contact has settled.
  bool settled = false;
  // Torque about the middle of the load that the contact settled with, over P, m: that of pressing, which
  // grows with P. As ContactPatch::torque_nm.
  double pressing_lever_m = 0;
  // Number of the block, from 1 in each contact.
  std::uint32_t block = 0;
};

// What one finger's pattern shows of an object that others hold as well.
struct PatternCourse {
  // How far the pattern has moved in each of the last confirming_blocks, over what one finger alone takes for
  // a slide: the least of them; >= 0.
  double moved = 0;
  // Change of the load, over P, in the time that the pattern is compared over: of the shear, >= 0; and of the
  // torque over the contact's radius of gyration, positive from x to y.
  double along = 0, torque = 0;
};

struct SlidingVerdict {
  // nullopt: this sensor, or this contact, cannot tell.
  std::optional<Sliding> sliding;
  // How long it has been so, s; 0 where it is not known.
  double for_s = 0;
  // None until the contact has settled, and without a zero.
  std::optional<PatternCourse> course = std::nullopt;
  FieldCourse field;
};

// Checked with `slipd-bench`. A contact has settled when as many blocks agree as last as long as kSureFrames
// of them: before, an overshoot counts as settled. "Share" is of P, no unit. TV is half the sum of the cells'
// changes in p/P: the share of the load that other cells carry now.
struct SlidingOptions {
  // Cells below which a contact has no pattern; 2 … 16. Too small: forces alone count as a pattern. Too
  // large: small arrays show nothing.
  std::size_t min_cells = 4;
  // The longest time that the pattern is compared over, and what a trend needs without a zero; blocks of
  // kBlock_s, 2 … TaxelBlocks::kKept - 1. Too small: slow slides are missed. Too large:
  // relaxation and drift of the skin add up.
  std::size_t compared_blocks = 8;
  // TV that a pattern moves by without sliding: rolling, the skin's own give; share, 0.02 … 0.2. Arms that
  // lift and swing an object held by 4 x 4 magnetic taxels reach 0.037. Too small: moved grasps slide, and
  // shaking contacts never settle. Too large: slides are seen late.
  double sticking_pattern = 0.045;
  // Blocks in a row above the limit; 1 … 5. Twice the limit needs one. Too small: a jolt slides. Too large:
  // late.
  std::uint32_t confirming_blocks = 2;
  // Below this share of the held P the gripper opens, above that it grips anew; 0.5 … 0.9, 1.1 … 3. Sliding
  // that was seen before ends where it has fallen beyond kBeyondUsual. Too near 1: a slide that frees the
  // grip goes unseen. Too far: opening counts as sliding.
  double opened_below = 0.75;
  double gripped_above = 1.5;
  // Blocks in which noise and the held P are followed to 1/e; 5 … 100. Too small: a slide counts as noise.
  // Too large: shaking that begins counts as sliding.
  double follow_blocks = 20;
  // Without a zero: the load changed when the root mean square of all channels moved by this many times the
  // noise of a block; 6 … 50. Too small: shaking and drift are disturbances. Too large: weak pulls are none.
  double disturbed_noises = 16;
  // Independent blocks, of all of a window: shaking is correlated in time; share, 0.2 … 1. Too small: slides
  // are missed. Too large: shaking slides.
  double independent_share = 0.5;
};

// Not thread-safe. Belongs to the estimate thread; allocates in its constructor only.
class SlidingDetector {
 public:
  // `false_alarms_per_hour`: of noise and shaking in a held grasp, by design; above 0.
  SlidingDetector(const TaxelLayout& layout, double false_alarms_per_hour,
                  const SlidingOptions& options = {});

  // `contact`: whether something touches the sensor; ignored where frame.zeroed is false.
  SlidingVerdict update(const Frame& frame, bool contact) noexcept;

 private:
  struct Change {
    double pattern = 0;     // TV
    double shear = 0;       // sum |d(q/P)|, share
    double log_normal = 0;  // ln of P now over P then
  };
  Change change_since(std::size_t ago) const noexcept;
  double normal_of(std::size_t ago) const noexcept;
  Sliding kind_since(std::size_t ago) const noexcept;
  PatternCourse course_since(std::size_t ago) const noexcept;
  std::optional<Sliding> judge_loaded() noexcept;
  std::optional<Sliding> judge_armed() noexcept;
  // most_fall: of P, from the blocks before to now, share.
  bool settled(double most_fall) const noexcept;
  void arm() noexcept;
  void take_reference() noexcept;
  void follow_field() noexcept;
  double coherence() const noexcept;
  // Of the load: its sum, its middle and its radius of gyration.
  struct Middle {
    double normal = 0, x_m = 0, y_m = 0, radius_m = 0;
  };
  Middle middle_of(const float* block) const noexcept;
  double lever_m() const noexcept;
  // Of shear since the contact settled, less what pressing makes: summed over cells, and of its sum; over P.
  struct FieldChange {
    double all = 0, along = 0;
  };
  FieldChange field_change() const noexcept;
  std::optional<Sliding> judge_raw() noexcept;
  void forget() noexcept;

  SlidingOptions options_;
  TaxelBlocks blocks_;
  // Change of ln P, as of a grip that overshot, with which the pattern of a contact that grows as Hertz's
  // does moves by sticking_pattern.
  const double relaxed_;
  double noise_factor_;  // of the mean noise of TV, that noise does not pass
  double trend_limit_;   // of a trend over its scatter
  bool has_pattern_;
  bool raw_ = false;              // the blocks are of frames without a zero
  bool armed_ = false;            // the contact has settled
  std::size_t compared_ = 0;      // blocks since it settled, at most compared_blocks
  double held_normal_ = 0;        // P of the hold
  double pattern_noise_ = 0;      // mean TV of neighbouring blocks
  double shear_noise_ = 0;        // mean change of q/P of neighbouring blocks
  std::uint32_t suspicious_ = 0;  // blocks in a row
  double moved_ = 0,
         moved_before_ = 0;  // of the pattern, over its limit: in the newest block, and in the one before
  std::optional<Sliding> now_;
  std::int64_t since_ns_ = 0;
  std::vector<float> settled_;  // the block in which the contact settled
  double settled_normal_ = 0;   // its P; 0: there is none
  std::optional<PatternCourse> course_;
  FieldCourse field_;
};

}  // namespace slipd
