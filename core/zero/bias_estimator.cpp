#include "core/zero/bias_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/frame/pause.hpp"
#include "core/frame/significance.hpp"
#include "core/health/usual.hpp"

namespace slipd {
namespace {

// Two blocks stand still if no channel's means differ by more standard errors than this, and a sensor without
// a bias reads 0 within it.
const auto kStillErrors = static_cast<float>(kStandsOutSigmas);
// What sums in single precision leave of a reading.
constexpr float kRounding = 8 * std::numeric_limits<float>::epsilon();

float square(float x) noexcept {
  return x * x;
}

}  // namespace

std::string_view to_string(BiasOrigin origin) noexcept {
  static constexpr std::string_view kNames[] = {"none", "command", "no_load"};
  return kNames[static_cast<std::size_t>(origin)];
}

std::string_view to_string(BiasResult answer) noexcept {
  static constexpr std::string_view kNames[] = {"none", "taken", "moving", "touched", "gone"};
  return kNames[static_cast<std::size_t>(answer)];
}

std::string_view to_string(BiasDoubt doubt) noexcept {
  static constexpr std::string_view kNames[] = {"none", "elsewhere", "below"};
  return kNames[static_cast<std::size_t>(doubt)];
}

BiasEstimator::BiasEstimator(const TaxelLayout& layout, Steps steps, const BiasEstimatorOptions& options,
                             bool exchangeable)
    : taxels_(layout.size()),
      steps_(steps),
      options_(options),
      finder_(layout),
      block_(taxels_),
      check_(taxels_, options.check),
      taken_bias_(3 * taxels_),
      last_mean_(3 * taxels_),
      last_variance_(3 * taxels_),
      apart_(3 * taxels_),
      sorted_(taxels_),
      exchangeable_(exchangeable),
      last_seen_(3 * taxels_) {
  zero_.bias_pa.resize(3 * taxels_);
  zero_.noise_pa.resize(3 * taxels_);
}

void BiasEstimator::restore(const Bias& zero) {
  if (zero.bias_pa.size() != 3 * taxels_ || zero.noise_pa.size() != 3 * taxels_)
    throw std::invalid_argument("a zero of " + std::to_string(zero.bias_pa.size() / 3) + " taxels, not of " +
                                std::to_string(taxels_));
  zero_ = zero;
  taken_bias_ = zero.bias_pa;
  report_.origin = zero.origin;
  report_.taken_ns = zero.taken_ns;
  report_.confirmed_ns = zero.confirmed_ns;
  report_.restored = true;
  measure_noise();
  check_.forget_pressed();
  has_last_seen_ = zero.last_pa.size() == last_seen_.size();
  if (has_last_seen_) last_seen_ = zero.last_pa;
  zero_.last_pa.clear();
  seen_frame_ = false;
  check_next_ = true;
}

void BiasEstimator::reopened() noexcept {
  note_absence();
  seen_free_ = report_.free = false;
  if (asked_) answer(BiasResult::gone);
}

void BiasEstimator::skip_requests(std::uint32_t upto) noexcept {
  report_.asked = upto;
  answer(BiasResult::gone);
}

void BiasEstimator::ask(std::uint32_t request, bool force) noexcept {
  report_.asked = request;
  asked_ = true;
  force_ = force;
  tries_ = 0;
  // Frames from before may be of what was held then.
  block_.forget();
  whole_ = false;
  last_frames_ = 0;
}

void BiasEstimator::apply(FrameSlot& frame) noexcept {
  const auto absent_ns = static_cast<std::int64_t>(kPause_s * 1e9);
  if (exchangeable_ && seen_frame_ && frame.time_ns - last_frame_ns_ > absent_ns) note_absence();
  last_frame_ns_ = frame.time_ns;
  seen_frame_ = true;
  if (check_next_) check_first(frame.view());
  whole_ = block_.add(frame) || whole_;
  frame.zeroed = trusted();
  if (!frame.zeroed) return;
  const float* bias = zero_.bias_pa.data();
  for (const auto& channel : {frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa}) {
    float* const values = channel.data();
#pragma omp simd
    for (std::size_t i = 0; i < taxels_; ++i) values[i] -= bias[i];
    bias += taxels_;
  }
}

// The sensor is away, or was. Frames from before and after make no block.
void BiasEstimator::note_absence() noexcept {
  // Without a frame since it was away before, what it read then still holds.
  if (trusted() && block_.newest_mean(last_seen_)) has_last_seen_ = true;
  block_.forget();
  whole_ = false;
  last_frames_ = 0;
  blocks_below_ = 0;
  check_next_ = true;
}

// The first frame after the sensor was away. With a serial number it is the same sensor, which only may have
// drifted.
void BiasEstimator::check_first(const Frame& frame) noexcept {
  check_next_ = false;
  if (!known()) return;
  const bool below = check_.is_below(frame, zero_, floors());
  if (exchangeable_ && !check_.agrees(frame, zero_, last_seen(), floors())) {
    set_doubt(below && shows_shape() ? BiasDoubt::below : BiasDoubt::elsewhere, frame);
  } else {
    set_doubt(below ? BiasDoubt::below : BiasDoubt::none, frame);
  }
}

// Whether a block speaks against the zero, or no longer does.
void BiasEstimator::review() noexcept {
  const Frame block = block_as_frame();
  const bool below = check_.is_below(block, zero_, floors());
  blocks_below_ = below ? blocks_below_ + 1 : 0;
  if (trusted()) {
    check_.note_pressed(block.normal_pa, zero_);
    if (blocks_below_ >= kSureFrames) set_doubt(BiasDoubt::below, block);
    return;
  }
  if (fits_again(block, below)) set_doubt(BiasDoubt::none, block);
  if (!trusted()) set_doubt(report_.doubt, block);
}

// A zero that was taken from a contact fits on all taxels that this contact did not touch, and seems to fit
// when the same is held again: only a reading that agrees everywhere speaks for it. Of few taxels, a pull may
// be the reason, and passes.
bool BiasEstimator::fits_again(const Frame& block, bool below) const noexcept {
  if (report_.doubt == BiasDoubt::below) return !below && (!shows_shape() || near_bias());
  return check_.agrees(block, zero_, last_seen(), floors());
}

void BiasEstimator::set_doubt(BiasDoubt doubt, const Frame& reading) noexcept {
  report_new_ = report_new_ || doubt != report_.doubt;
  report_.doubt = doubt;
  report_.off_pa = doubt == BiasDoubt::none ? 0 : ZeroCheck::mean_off_pa(reading, zero_);
}

ZeroCheck::Floors BiasEstimator::floors() const noexcept {
  return {report_.noise_normal_pa, report_.noise_shear_pa, steps_.normal_pa, steps_.shear_pa};
}

Frame BiasEstimator::block_as_frame() const noexcept {
  const auto now = block_.mean_pa();
  return {.normal_pa = now.first(taxels_),
          .shear_x_pa = now.subspan(taxels_, taxels_),
          .shear_y_pa = now.last(taxels_)};
}

std::vector<float> BiasEstimator::last_reading() const {
  std::vector<float> last(3 * taxels_);
  return trusted() && block_.newest_mean(last) ? last : std::vector<float>();
}

bool BiasEstimator::judge() noexcept {
  const bool changed = std::exchange(report_new_, false);
  if (!whole_) return changed;
  whole_ = false;
  if (known()) review();
  report_new_ = false;
  const bool has_last = last_frames_ > 0;
  const bool still = has_last && stands_still();
  report_.free = false;
  if (asked_) {
    if (has_last) answer_request(still);
  } else if (still && (trusted() ? near_bias() : reads_zero()) && !stands_out()) {
    if (trusted()) {
      follow();
    } else {
      take(BiasOrigin::no_load);
    }
  }
  keep_block();
  return true;
}

void BiasEstimator::answer_request(bool still) noexcept {
  if (!still) {
    if (++tries_ >= options_.max_tries) answer(BiasResult::moving);
    return;
  }
  if (!force_ && looks_touched()) return answer(BiasResult::in_contact);
  take(BiasOrigin::command);
  answer(BiasResult::taken);
}

void BiasEstimator::answer(BiasResult what) noexcept {
  asked_ = false;
  report_.answered = report_.asked;
  report_.answer = what;
}

// Whether this block and the one before are of one and the same reading. The noise is that of the quieter of
// both: a touch that began within the other one is in its variance, too.
bool BiasEstimator::stands_still() const noexcept {
  const auto now = block_.mean_pa();
  const Kinds least = quieter_by_kind();
  // Flicker noise does not fall with the number of frames.
  const auto independent = [](std::uint32_t frames) {
    return static_cast<float>(std::min(kMemoryFrames, frames));
  };
  const float errors = 1 / independent(block_.frames()) + 1 / independent(last_frames_);
  for (std::size_t i = 0; i < now.size(); ++i) {
    const float variance = std::max(quieter(i), i < taxels_ ? least.normal : least.shear);
    const float within = square(kStillErrors) * errors * variance + square(kRounding * now[i]);
    if (!(square(now[i] - last_mean_[i]) <= within)) return false;  // as for what is no number
  }
  return true;
}

// Without a zero yet: whether the sensor reads 0 all over. A load that hides every offset, taxel by taxel,
// there is not.
bool BiasEstimator::reads_zero() const noexcept {
  const auto now = block_.mean_pa();
  const Kinds least = quieter_by_kind();
  const float frames = static_cast<float>(block_.frames() + last_frames_);
  for (std::size_t i = 0; i < now.size(); ++i) {
    const float variance = std::max(quieter(i), i < taxels_ ? least.normal : least.shear);
    const float within = std::max(kStillErrors * std::sqrt(variance / frames), step_pa(i) / 2);
    if (!(std::abs(now[i] + last_mean_[i]) / 2 <= within)) return false;
  }
  return true;
}

float BiasEstimator::quieter(std::size_t channel) const noexcept {
  return std::min(block_.variance_pa2()[channel], last_variance_[channel]);
}

BiasEstimator::Kinds BiasEstimator::quieter_by_kind() const noexcept {
  const Kinds now = mean_by_kind(block_.variance_pa2()), last = mean_by_kind(last_variance_);
  // A reading that stands between two steps flickers by this much, seen or not.
  const auto rounding = [](float step_pa) { return square(step_pa) / 12; };
  return {std::max(std::min(now.normal, last.normal), rounding(steps_.normal_pa)),
          std::max(std::min(now.shear, last.shear), rounding(steps_.shear_pa))};
}

BiasEstimator::Kinds BiasEstimator::mean_by_kind(std::span<const float> values) const noexcept {
  double normal = 0, shear = 0;
  for (std::size_t i = 0; i < taxels_; ++i) normal += values[i];
  for (std::size_t i = taxels_; i < 3 * taxels_; ++i) shear += values[i];
  const auto n = static_cast<double>(taxels_);
  return {static_cast<float>(normal / n), static_cast<float>(shear / (2 * n))};
}

// With a zero: whether every channel is at it, but for noise and what drift may have done meanwhile.
bool BiasEstimator::near_bias() const noexcept {
  const auto now = block_.mean_pa();
  for (std::size_t i = 0; i < now.size(); ++i) {
    const float least = i < taxels_ ? report_.noise_normal_pa : report_.noise_shear_pa;
    const float within = std::max(static_cast<float>(kClearSigmas) * std::max(zero_.noise_pa[i], least),
                                  static_cast<float>(kStrongSigmas) * rounding_noise(step_pa(i))) +
                         kRounding * std::abs(now[i]);
    if (!(std::abs(now[i] - zero_.bias_pa[i]) <= within)) return false;
  }
  return true;
}

// Whether the block differs from the bias (from 0, while there is none to trust) as a contact does: some
// taxels that lie together, more than what the others differ by. What all have in common is drift.
bool BiasEstimator::stands_out() noexcept {
  if (!shows_shape()) return false;
  const auto now = block_.mean_pa();
  const float share = trusted() ? 1 : 0;
  for (std::size_t i = 0; i < now.size(); ++i) apart_[i] = now[i] - share * zero_.bias_pa[i];
  std::copy_n(apart_.begin(), taxels_, sorted_.begin());
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(taxels_ / 2);
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  for (std::size_t i = 0; i < taxels_; ++i) apart_[i] -= *middle;
  const std::span<const float> all(apart_);
  const ContactPatch& patch = finder_.find({.normal_pa = all.first(taxels_),
                                            .shear_x_pa = all.subspan(taxels_, taxels_),
                                            .shear_y_pa = all.last(taxels_)});
  if (!patch.in_contact) return false;
  int out = 0;
  patch.for_each_inside(
      [&](std::uint32_t taxel) { out += apart_[taxel] > kStandsOutSigmas * patch.noise_normal_pa ? 1 : 0; });
  return out >= static_cast<int>(kBadTaxels);
}

// What speaks against a zero that was asked for. A sensor that was seen free since it was opened, and no
// longer is, is touched. One that was not may have drifted while it was away: then only shape tells.
bool BiasEstimator::looks_touched() noexcept {
  return (trusted() && seen_free_ && !near_bias()) || stands_out();
}

void BiasEstimator::take(BiasOrigin origin) noexcept {
  const auto now = block_.mean_pa(), spread = block_.variance_pa2();
  const float share =
      static_cast<float>(block_.frames()) / static_cast<float>(block_.frames() + last_frames_);
  for (std::size_t i = 0; i < now.size(); ++i) {
    zero_.bias_pa[i] = last_mean_[i] + share * (now[i] - last_mean_[i]);
    zero_.noise_pa[i] = std::sqrt(last_variance_[i] + share * (spread[i] - last_variance_[i]));
  }
  std::copy(zero_.bias_pa.begin(), zero_.bias_pa.end(), taken_bias_.begin());
  zero_.origin = report_.origin = origin;
  zero_.taken_ns = report_.taken_ns = block_.ended_ns();
  zero_.confirmed_ns = report_.confirmed_ns = block_.ended_ns();
  report_.drift_pa = 0;
  report_.doubt = BiasDoubt::none;
  report_.off_pa = 0;
  has_last_seen_ = false;
  check_.forget_pressed();
  blocks_below_ = 0;
  report_.restored = false;
  report_.free = seen_free_ = true;
  ++report_.taken;
  measure_noise();
}

void BiasEstimator::follow() noexcept {
  const auto now = block_.mean_pa();
  const double seconds = 1e-9 * static_cast<double>(block_.ended_ns() - last_ended_ns_);
  const auto share = static_cast<float>(1 - std::exp(-std::clamp(seconds, 0.0, kPause_s) / kDrift_s));
  float way = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    zero_.bias_pa[i] += share * (now[i] - zero_.bias_pa[i]);
    way = std::max(way, std::abs(zero_.bias_pa[i] - taken_bias_[i]));
  }
  report_.drift_pa = way;
  zero_.confirmed_ns = report_.confirmed_ns = block_.ended_ns();
  report_.free = seen_free_ = true;
}

void BiasEstimator::measure_noise() noexcept {
  for (std::size_t i = 0; i < apart_.size(); ++i) apart_[i] = square(zero_.noise_pa[i]);
  const Kinds variance = mean_by_kind(apart_);
  report_.noise_normal_pa = std::sqrt(variance.normal);
  report_.noise_shear_pa = std::sqrt(variance.shear);
}

void BiasEstimator::keep_block() noexcept {
  std::copy(block_.mean_pa().begin(), block_.mean_pa().end(), last_mean_.begin());
  std::copy(block_.variance_pa2().begin(), block_.variance_pa2().end(), last_variance_.begin());
  last_frames_ = block_.frames();
  last_ended_ns_ = block_.ended_ns();
}

}  // namespace slipd
