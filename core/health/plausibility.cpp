#include "core/health/plausibility.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/frame/few_taxels.hpp"
#include "core/frame/significance.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

enum ChannelNumber : std::size_t { normal_channel, shear_x_channel, shear_y_channel };

constexpr std::array kDeadChannel{Health::dead_normal, Health::dead_shear_x, Health::dead_shear_y};

// Probes that change in each frame, from which on two frames are not alike by chance.
constexpr double kSureProbes = 6;

// Taxels of which no contact presses all at once; a pad of fewer may be smaller than a contact.
constexpr std::size_t kManyTaxels = 9;

// Rows and columns that are learnt from in a frame.
constexpr std::size_t kLinesLearnt = 8;

// The normal force of a contact does not fall by this factor in one frame and stay.
const double kVanished = kWrongScale * kWrongScale;

// Normal force may fall by this factor with an unloading while shear vanishes with it.
constexpr double kUnloading = 0.5;

// What two frames of one measurement have in common: all that is summed or sought over whole frames, as
// probes may miss a small contact.
auto sums_of(const ContactNumbers& of) noexcept {
  return std::tuple(of.normal_n, of.shear_x_n, of.shear_y_n, of.torque_nm, of.peak_pa, of.shear_x_extreme_pa,
                    of.shear_y_extreme_pa, of.frame_peak_pa, of.frame_least_pa);
}

}  // namespace

PlausibilityMonitor::PlausibilityMonitor(const TaxelLayout& layout, const PlausibilityLimits& limits,
                                         const PlausibilityOptions& options)
    : layout_(layout),
      limits_(limits),
      options_(options),
      spikes_(layout, limits, options.spikes),
      probes_(layout, kSampled),
      continuity_(options.continuity),
      lines_(probes_.lines()) {}

void PlausibilityMonitor::blame(Verdict verdict, Health health) noexcept {
  if (verdict < now_.verdict || (verdict == now_.verdict && now_.health != Health::good)) return;
  now_.verdict = verdict;
  now_.health = health;
}

bool PlausibilityMonitor::screen(const Frame& frame, const ContactPatch& patch) noexcept {
  spikes_found_ = spikes_.find(frame, patch);
  return spikes_found_ > 0 && spikes_found_ <= spikes_.may_leave();
}

const Judgement& PlausibilityMonitor::judge(const Frame& frame, const ContactPatch& patch) noexcept {
  now_ = {};
  if (since_repeat_ < kNever) ++since_repeat_;
  probes_.update(frame);
  judge_values(patch);
  judge_size(patch);
  judge_offset(patch);
  const SeenFrame now{frame.time_ns, patch};
  judge_course(now);
  const bool frozen = judge_frozen();
  if (!frozen) {
    for (std::size_t c = 0; c < kChannels; ++c) judge_channel(c, patch);
    for (std::size_t c = 0; c < kChannels; ++c) judge_rail(c, frame, patch);
    judge_lines();
    judge_past();
  }
  if (noise_jump_.update(probes_.channels(), patch.in_contact)) blame(Verdict::frame_refused, Health::noisy);
  judge_continuity(now);
  judge_time(frame.time_ns);
  const bool repeats = frozen && before_ && sums_of(before_->contact) == sums_of(now.contact);
  learn_change(patch);
  before_ = now;
  before_->believed = now_.verdict < Verdict::frame_refused;
  hold();
  now_.repeats = repeats;
  return now_;
}

void PlausibilityMonitor::judge_values(const ContactPatch& patch) noexcept {
  if (spikes_found_ > 0) {
    now_.taxels_left_out = static_cast<std::uint32_t>(spikes_found_);
    if (patch.normal_n > 0) now_.left_out_share = std::min(1.0, spikes_.left_out_n() / patch.normal_n);
    if (spikes_found_ <= spikes_.may_leave()) {
      const bool enough = now_.left_out_share <= kBadShare;
      blame(enough ? Verdict::taxels_left_out : Verdict::frame_refused, Health::spike);
    } else {
      blame(Verdict::frame_refused, patch.finite ? Health::full_scale : Health::not_finite);
    }
  }
  const bool finite = patch.finite && std::isfinite(patch.normal_n) && std::isfinite(patch.shear_n) &&
                      std::isfinite(patch.noise_shear_pa);
  if (!finite) blame(Verdict::frame_refused, Health::not_finite);
  if (layout_.size() == 1 && patch.frame_peak_pa > limits_.full_scale.normal_pa)
    blame(Verdict::frame_refused, Health::full_scale);
  if (layout_.size() > 2 && patch.frame_peak_pa > 0 && patch.frame_peak_pa == patch.frame_least_pa)
    blame(Verdict::frame_refused, Health::uniform);
}

// Hertz: a^3 = 3 R P/(4 E*), whose factor the scene bounds. Contacts of other shapes are within kWrongScale.
void PlausibilityMonitor::judge_size(const ContactPatch& patch) noexcept {
  if (!patch.in_contact || patch.cut || limits_.least_m3_per_n <= 0) return;
  if (patch.normal_n < kStrongSigmas * patch.normal_sigma_n) return;
  const double volume_m3 = patch.radius_m * patch.radius_m * patch.radius_m;
  const bool sized = patch.count >= kFewInside;
  const bool small = sized && patch.normal_n * limits_.greatest_m3_per_n * kWrongScale < volume_m3;
  const bool large = patch.normal_n * limits_.least_m3_per_n > kWrongScale * volume_m3;
  if (small || large) blame(Verdict::frame_refused, Health::wrong_scale);
}

void PlausibilityMonitor::judge_time(std::int64_t time_ns) noexcept {
  if (before_ && time_ns <= before_->time_ns) blame(Verdict::plausible, Health::time);
}

// An offset of all taxels: what was next to nothing everywhere is suddenly not, or of a flat skin, what was
// held is suddenly several times as much, by the same on each taxel.
bool PlausibilityMonitor::raised(const ContactPatch& patch) const noexcept {
  const double least_pa = before_->contact.frame_least_pa, peak_pa = before_->contact.frame_peak_pa;
  const double rise_pa = static_cast<double>(patch.frame_least_pa) - least_pa;
  if (limits_.flat) {
    const double peak_rise_pa = static_cast<double>(patch.frame_peak_pa) - peak_pa;
    const bool steady = change_.known() && change_.mean < kChanged;
    return steady && rise_pa > kBeyondUsual * peak_pa &&
           std::fabs(peak_rise_pa - rise_pa) < kChanged * rise_pa;
  }
  const bool small_before = std::fabs(least_pa) < kUnloading * peak_pa;
  return small_before && rise_pa > options_.least_rise_share * peak_pa;
}

void PlausibilityMonitor::judge_offset(const ContactPatch& patch) noexcept {
  if (lifted_pa_ > 0 && patch.frame_least_pa < lifted_pa_) lifted_pa_ = 0;
  if (patch.finite && layout_.size() >= kManyTaxels && touched_before() && raised(patch))
    lifted_pa_ = patch.frame_least_pa / 2;
  if (lifted_pa_ > 0) blame(Verdict::frame_refused, Health::jump);
}

// What the contact did since the last frame.
void PlausibilityMonitor::judge_course(const SeenFrame& now) noexcept {
  if (!now.contact.in_contact || !touched_before()) {
    fallen_from_n_ = 0;
    return;
  }
  const ContactNumbers &contact = now.contact, &before = before_->contact;
  if (fallen_from_n_ > 0) {
    if (contact.normal_n * kVanished > fallen_from_n_) {
      fallen_from_n_ = 0;
    } else {
      blame(Verdict::frame_refused, Health::wrong_scale);
    }
  } else if (before_->believed && contact.normal_n * kVanished < before.normal_n) {
    fallen_from_n_ = before.normal_n;
  }
  const double moved_m = norm(contact.center_x_m - before.center_x_m, contact.center_y_m - before.center_y_m);
  const double most_m = std::max(contact.radius_m, before.radius_m) + options_.jump_sides * layout_.side_m();
  if (layout_.size() > 1 && now.clear() && before_->clear() && moved_m > most_m)
    blame(Verdict::frame_refused, Health::jump);
}

void PlausibilityMonitor::judge_continuity(const SeenFrame& now) noexcept {
  if (now_.verdict != Verdict::plausible || layout_.size() == 1) return continuity_.skip();
  const Health health = continuity_.update(now, before_, probes_.pattern(), probes_.size());
  if (health != Health::good) blame(Verdict::frame_refused, health);
}

// True if this frame is the one before, in all probes.
bool PlausibilityMonitor::judge_frozen() noexcept {
  GroupChange all;
  std::size_t nonzero = 0;
  for (const ChannelChange& channel : probes_.channels()) {
    all.values += channel.change.values;
    all.changed += channel.change.changed;
    all.turned += channel.change.turned;
    nonzero += channel.nonzero;
  }
  sensed_ = nonzero > 0;
  if (!sensed_) {  // and there is no noise: nothing can freeze
    frame_stillness_.skip();
    return false;
  }
  if (frame_stillness_.update(all)) {
    blame_repeated(frame_stillness_.run());
  }
  return all.changed == 0;
}

// A frame other than the last one that was there before: of a sensor with noise, a block that is played
// again.
void PlausibilityMonitor::judge_past() noexcept {
  if (!sensed_) return;
  const std::uint64_t now = probes_.fingerprint();
  bool seen = false;
  for (const std::uint64_t then : past_) seen |= then == now;
  past_[next_past_] = now;
  next_past_ = (next_past_ + 1) % past_.size();
  const bool sure = frame_stillness_.noisy() &&
                    static_cast<double>(probes_.size()) * frame_stillness_.changing() > kSureProbes;
  past_run_ = seen && sure ? past_run_ + 1 : 0;
  if (past_run_ > 0) blame_repeated(past_run_);
}

// A frame that was there before, the last one of so many in a row.
void PlausibilityMonitor::blame_repeated(std::uint32_t run) noexcept {
  const std::uint32_t since = std::exchange(since_repeat_, 0);
  if (run >= kSureFrames) {
    blame(Verdict::sensor_fault, Health::frozen);
  } else if (since <= learning_frames()) {  // drivers and recordings have a frame twice now and then
    blame(Verdict::plausible, Health::repeated);
  }
}

void PlausibilityMonitor::judge_channel(std::size_t channel, const ContactPatch& patch) noexcept {
  Channel& is = channels_[channel];
  const ChannelChange& seen = probes_.channels()[channel];
  if (!patch.in_contact) {
    is.alive_in_contact = false;
    if (seen.nonzero > 0 && is.alive_free < learning_frames()) ++is.alive_free;
  }
  const bool normal = channel == normal_channel;
  if (seen.change.changed > 0) {
    is.stillness.update(seen.change);
    const bool vanished = !normal && seen.nonzero == 0 && seen.nonzero_before >= kBadTaxels &&
                          patch.in_contact && touched_before() &&
                          patch.normal_n > kUnloading * before_->contact.normal_n;
    is.dead = vanished;
  } else if (normal || seen.nonzero > 0 || is.alive_in_contact || is.alive_free >= learning_frames()) {
    is.dead = is.stillness.update(seen.change) || is.dead;
  } else {
    is.stillness.skip();  // no shear yet, of a sensor without noise of its own
    is.dead = is.dead && patch.in_contact;
  }
  if (patch.in_contact && seen.nonzero > 0) is.alive_in_contact = true;
  if (is.dead) blame(Verdict::sensor_fault, kDeadChannel[channel]);
}

// A line that does not stand still is learnt from now and then only, if there are many.
void PlausibilityMonitor::judge_lines() noexcept {
  if (!sensed_) return;
  const std::size_t turns = 1 + lines_.size() / kLinesLearnt;
  turn_ = (turn_ + 1) % turns;
  const bool all_move = !probes_.any_still() && !lines_stand_;
  lines_stand_ = false;
  for (std::size_t line = all_move ? turn_ : 0; line < lines_.size(); line += all_move ? turns : 1) {
    Stillness& stillness = lines_[line];
    if (line % turns != turn_ && stillness.run() == 0 && probes_.line_moved(line)) continue;
    const bool still = stillness.update(probes_.line(line));
    lines_stand_ = lines_stand_ || stillness.run() > 0;
    if (still && stillness.run() >= kSureFrames) blame(Verdict::sensor_fault, Health::dead_row);
  }
}

// A saturated channel's greatest value is the rail, frame for frame, while others change. How often it
// repeats by itself is learnt, since values may be quantised; each taxel at the rail is evidence.
void PlausibilityMonitor::judge_rail(std::size_t channel, const Frame& frame,
                                     const ContactPatch& patch) noexcept {
  Channel& is = channels_[channel];
  const std::array extremes{patch.peak_pa, patch.shear_x_extreme_pa, patch.shear_y_extreme_pa};
  const float extreme_pa = patch.in_contact ? extremes[channel] : 0;
  const float step_pa = extreme_pa - is.last_extreme_pa;
  const bool comparable = extreme_pa > 0 && is.last_extreme_pa > 0;
  is.last_extreme_pa = extreme_pa;
  if (!comparable || probes_.channels()[channel].change.changed == 0) return is.extreme.skip();
  if (step_pa != 0) {
    is.extreme.update({1, 1, step_pa * is.extreme_step_pa < 0 ? 1U : 0U});
    is.extreme_step_pa = step_pa;
  } else {
    const std::size_t at_rail = count_at(channel, extreme_pa, frame, patch);
    const bool many =
        at_rail >= std::max<std::size_t>(
                       kFewInside, static_cast<std::size_t>(kBadShare * static_cast<double>(patch.count)));
    const bool still = is.extreme.update({std::max<std::size_t>(at_rail, 1), 0, 0});
    if (is.extreme.run() >= kSureFrames && (still || many)) is.rail_pa = extreme_pa;
  }
  if (extreme_pa == is.rail_pa) blame(Verdict::frame_refused, Health::saturated);
}

// Taxels of the contact whose value has this magnitude.
std::size_t PlausibilityMonitor::count_at(std::size_t channel, float magnitude_pa, const Frame& frame,
                                          const ContactPatch& patch) noexcept {
  const std::array values{frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa};
  std::size_t count = 0;
  patch.for_each_inside(
      [&](std::uint32_t i) { count += std::fabs(values[channel][i]) == magnitude_pa ? 1 : 0; });
  return count;
}

void PlausibilityMonitor::learn_change(const ContactPatch& patch) noexcept {
  if (!patch.in_contact || !touched_before() || !(patch.normal_n > 0) || !(before_->contact.normal_n > 0)) {
    change_ = {};
  } else {
    change_.learn(std::fabs(std::log(patch.normal_n / before_->contact.normal_n)));
  }
}

// A fault lasts until kSureFrames without one have passed.
void PlausibilityMonitor::hold() noexcept {
  if (now_.verdict >= Verdict::frame_refused) {
    held_ = now_;
    good_run_ = 0;
  } else if (held_.health != Health::good) {
    if (++good_run_ >= kSureFrames) {
      held_ = {};
    } else {
      now_ = held_;
    }
  }
}

}  // namespace slipd
