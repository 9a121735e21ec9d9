#include "core/sliding/sliding.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/frame/pause.hpp"
#include "core/health/usual.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

constexpr double kSecondsPerHour = 3600;
// Standard deviation of |x| over its mean, for Gaussian x: sqrt(pi/2 - 1).
constexpr double kFoldedScatter = 0.7555;
// TV for each e-fold of P of a contact that grows as Hertz's does, the fastest of the usual ones: a ~
// P^(1/3), and TV = 2/sqrt(3) |d ln a|.
constexpr double kPatternPerLogNormal = 2 / (3 * std::numbers::sqrt3);

// z with P(x > z) = p for a Gaussian x; p below 0.1. The tail phi(z)/z, solved by iteration.
double gaussian_limit(double p) {
  double z = 4;
  for (int i = 0; i < 20; ++i)
    z = std::sqrt(std::max(1.0, -2 * std::log(p * z * std::sqrt(2 * std::numbers::pi))));
  return z;
}

// t with P(|x| > t) = p for Student's x with `freedom` degrees, from the power law of its tail; p below 0.01.
double student_limit(double p, double freedom) {
  const double tail = std::tgamma((freedom + 1) / 2) * std::pow(freedom, (freedom - 1) / 2) /
                      (std::sqrt(std::numbers::pi) * std::tgamma(freedom / 2));
  return std::pow(2 * tail / p, 1 / freedom);
}

// The largest net change of a straight line over `blocks`, over its scatter, that independent noise reaches
// as often as allowed. slope = t scatter / sqrt(sum of squared times).
double trend_limit_of(double false_alarms_per_hour, const SlidingOptions& options) {
  const auto n = static_cast<double>(TaxelBlocks::kKept);
  const double windows_per_hour = kSecondsPerHour / (kBlock_s * n);
  const double p = std::min(0.01, false_alarms_per_hour / windows_per_hour);
  const double freedom = options.independent_share * (n - 2);
  const double squared_times = n * (n * n - 1) / 12;
  return student_limit(p, freedom) * (n - 1) / std::sqrt(squared_times);
}

// A tangential field's resultant, and its torque over a length, both as force.
struct Resultant {
  double x = 0, y = 0, torque = 0;
  double along() const noexcept { return norm(x, y); }
};

// The length of (x, y), whose components have noise of this standard deviation, without what noise adds.
double without_noise(double x, double y, double sigma) noexcept {
  return std::sqrt(std::max(0.0, x * x + y * y - 2 * sigma * sigma));
}

}  // namespace

std::string_view to_string(Sliding sliding) noexcept {
  static constexpr std::string_view kNames[] = {"none", "disturbed", "translation", "rotation"};
  return kNames[static_cast<std::size_t>(sliding)];
}

SlidingDetector::SlidingDetector(const TaxelLayout& layout, double false_alarms_per_hour,
                                 const SlidingOptions& options)
    : options_(options),
      blocks_(layout),
      relaxed_(options.sticking_pattern / kPatternPerLogNormal),
      has_pattern_(blocks_.cells() >= options.min_cells) {
  const double blocks_per_hour = kSecondsPerHour / kBlock_s;
  noise_factor_ =
      1 + kFoldedScatter * gaussian_limit(std::min(0.01, false_alarms_per_hour / blocks_per_hour));
  trend_limit_ = trend_limit_of(false_alarms_per_hour, options);
  settled_.resize(3 * blocks_.cells());
}

void SlidingDetector::forget() noexcept {
  blocks_.forget();
  armed_ = false;
  suspicious_ = 0;
  moved_ = moved_before_ = 0;
  course_.reset();
  now_.reset();
  settled_normal_ = 0;
  field_ = {};
}

SlidingVerdict SlidingDetector::update(const Frame& frame, bool contact) noexcept {
  if (!has_pattern_) return {};
  if (frame.zeroed == raw_ || (frame.zeroed && !contact)) {
    raw_ = !frame.zeroed;
    forget();
    if (frame.zeroed && !contact) return {};
  }
  if (blocks_.add(frame)) {
    const auto judged = raw_ ? judge_raw() : judge_loaded();
    if (judged != now_) since_ns_ = frame.time_ns;
    now_ = judged;
    if (!raw_) follow_field();
  }
  if (!now_) return {.sliding = {}, .for_s = 0, .course = course_, .field = field_};
  return {now_, static_cast<double>(frame.time_ns - since_ns_) * 1e-9, course_, field_};
}

void SlidingDetector::follow_field() noexcept {
  field_.known = true;
  const FieldChange change = field_change();
  field_.settled = settled_normal_ > 0;
  field_.internal_share = std::max(0.0, change.all - change.along);
  course_.reset();
  if (armed_) course_ = course_since(std::min(compared_, blocks_.size() - 1));
  field_.coherence = coherence();
  if (change.all > kChanged) field_.coherence = std::max(field_.coherence, change.along / change.all);
  ++field_.block;
}

double SlidingDetector::coherence() const noexcept {
  const std::size_t cells = blocks_.cells();
  const float* const now = blocks_.block(0);
  Resultant sum;
  double all = 0;
  for (std::size_t i = 0; i < cells; ++i) {
    const auto x = static_cast<double>(now[cells + i]), y = static_cast<double>(now[2 * cells + i]);
    sum.x += x;
    sum.y += y;
    all += without_noise(x, y, blocks_.noise());
  }
  return all > 0 ? std::min(1.0, sum.along() / all) : 1;
}

SlidingDetector::Middle SlidingDetector::middle_of(const float* block) const noexcept {
  Middle middle;
  double square = 0;
  for (std::size_t i = 0; i < blocks_.cells(); ++i) {
    const double p = std::max(0.0, static_cast<double>(block[i]));
    middle.normal += p;
    middle.x_m += p * blocks_.x_m(i);
    middle.y_m += p * blocks_.y_m(i);
    square += p * (blocks_.x_m(i) * blocks_.x_m(i) + blocks_.y_m(i) * blocks_.y_m(i));
  }
  if (!(middle.normal > 0)) return {};
  middle.x_m /= middle.normal;
  middle.y_m /= middle.normal;
  const double off = middle.x_m * middle.x_m + middle.y_m * middle.y_m;
  middle.radius_m = std::sqrt(std::max(0.0, square / middle.normal - off));
  return middle;
}

double SlidingDetector::lever_m() const noexcept {
  const std::size_t cells = blocks_.cells();
  const float* const now = blocks_.block(0);
  const Middle middle = middle_of(now);
  if (!(middle.normal > 0)) return 0;
  double torque = 0;
  for (std::size_t i = 0; i < cells; ++i)
    torque += (blocks_.x_m(i) - middle.x_m) * static_cast<double>(now[2 * cells + i]) -
              (blocks_.y_m(i) - middle.y_m) * static_cast<double>(now[cells + i]);
  return torque / middle.normal;
}

SlidingDetector::FieldChange SlidingDetector::field_change() const noexcept {
  if (!(settled_normal_ > 0)) return {};
  const double normal = normal_of(0);
  if (!(normal > 0)) return {.all = 1, .along = 0};
  const std::size_t cells = blocks_.cells();
  const float* const now = blocks_.block(0);
  const double scale = normal / settled_normal_, noise = blocks_.noise() * norm(1, scale);
  Resultant change;
  double all = 0;
  for (std::size_t i = cells; i < 2 * cells; ++i) {
    const double x = static_cast<double>(now[i]) - scale * static_cast<double>(settled_[i]);
    const double y = static_cast<double>(now[cells + i]) - scale * static_cast<double>(settled_[cells + i]);
    change.x += x;
    change.y += y;
    all += without_noise(x, y, noise);
  }
  return {.all = all / normal, .along = std::min(all, change.along()) / normal};
}

PatternCourse SlidingDetector::course_since(std::size_t ago) const noexcept {
  const std::size_t cells = blocks_.cells();
  const float* const now = blocks_.block(0);
  const float* const then = blocks_.block(ago);
  const Middle middle = middle_of(now), before = middle_of(then);
  if (!(middle.radius_m > 0) || !(before.normal > 0)) return {};
  Resultant change;
  for (std::size_t i = 0; i < cells; ++i) {
    const double x = static_cast<double>(now[cells + i]) / middle.normal -
                     static_cast<double>(then[cells + i]) / before.normal;
    const double y = static_cast<double>(now[2 * cells + i]) / middle.normal -
                     static_cast<double>(then[2 * cells + i]) / before.normal;
    change.x += x;
    change.y += y;
    change.torque += (blocks_.x_m(i) - middle.x_m) * y - (blocks_.y_m(i) - middle.y_m) * x;
  }
  return {.moved = std::min(moved_, moved_before_),
          .along = change.along(),
          .torque = change.torque / middle.radius_m};
}

double SlidingDetector::normal_of(std::size_t ago) const noexcept {
  const float* const p = blocks_.block(ago);
  double sum = 0;
  for (std::size_t i = 0; i < blocks_.cells(); ++i) sum += static_cast<double>(p[i]);
  return sum;
}

SlidingDetector::Change SlidingDetector::change_since(std::size_t ago) const noexcept {
  const double normal_now = normal_of(0), normal_then = normal_of(ago);
  if (!(normal_now > 0) || !(normal_then > 0)) return {.pattern = 1, .shear = 1, .log_normal = 1};
  Change change{.pattern = 0, .shear = 0, .log_normal = std::log(normal_now / normal_then)};
  const std::size_t cells = blocks_.cells();
  const float* const now = blocks_.block(0);
  const float* const then = blocks_.block(ago);
  for (std::size_t i = 0; i < cells; ++i) {
    const auto difference = [&](std::size_t channel) {
      return static_cast<double>(now[channel * cells + i]) / normal_now -
             static_cast<double>(then[channel * cells + i]) / normal_then;
    };
    change.pattern += std::fabs(difference(0)) / 2;
    change.shear += norm(difference(1), difference(2));
  }
  return change;
}

// What the change of the tangential field is most: along, or a turn about the middle of the load.
Sliding SlidingDetector::kind_since(std::size_t ago) const noexcept {
  const std::size_t cells = blocks_.cells();
  const float* const now = blocks_.block(0);
  const float* const then = blocks_.block(ago);
  const double normal_now = raw_ ? 1 : normal_of(0), normal_then = raw_ ? 1 : normal_of(ago);
  double weight = 0, x_m = 0, y_m = 0, square = 0, moved_x = 0, moved_y = 0;
  const auto share = [&](std::size_t i) {
    return raw_ ? 1 / static_cast<double>(cells) : std::max(0.0, static_cast<double>(now[i]) / normal_now);
  };
  for (std::size_t i = 0; i < cells; ++i) {
    const double w = share(i);
    weight += w;
    x_m += w * blocks_.x_m(i);
    y_m += w * blocks_.y_m(i);
    if (raw_) continue;
    const double d = static_cast<double>(now[i]) / normal_now - static_cast<double>(then[i]) / normal_then;
    moved_x += d * blocks_.x_m(i);
    moved_y += d * blocks_.y_m(i);
  }
  x_m /= weight;
  y_m /= weight;
  Resultant change;
  for (std::size_t i = 0; i < cells; ++i) {
    const double rx = blocks_.x_m(i) - x_m, ry = blocks_.y_m(i) - y_m;
    square += share(i) * (rx * rx + ry * ry) / weight;
    const double qx =
        static_cast<double>(now[cells + i]) / normal_now - static_cast<double>(then[cells + i]) / normal_then;
    const double qy = static_cast<double>(now[2 * cells + i]) / normal_now -
                      static_cast<double>(then[2 * cells + i]) / normal_then;
    change.x += qx;
    change.y += qy;
    change.torque += rx * qy - ry * qx;
  }
  const double a_m = std::sqrt(square);
  const double along = std::max(change.along(), a_m > 0 ? norm(moved_x, moved_y) / a_m : 0);
  return a_m > 0 && std::fabs(change.torque) / a_m > along ? Sliding::rotation : Sliding::translation;
}

bool SlidingDetector::settled(double most_fall) const noexcept {
  const std::size_t agreeing = blocks_.blocks_in(kSureFrames);
  if (blocks_.size() <= agreeing) return false;
  for (std::size_t ago = 1; ago <= agreeing; ++ago) {
    const Change change = change_since(ago);
    if (change.pattern > options_.sticking_pattern || change.log_normal > kChanged ||
        change.log_normal < -most_fall)
      return false;
  }
  return true;
}

// The field that pressing makes: of the first hold in which P does not fall any more.
void SlidingDetector::take_reference() noexcept {
  std::copy_n(blocks_.block(0), settled_.size(), settled_.begin());
  settled_normal_ = normal_of(0);
  field_.pressing_lever_m = lever_m();
}

void SlidingDetector::arm() noexcept {
  const Change last = change_since(1);
  if (!armed_) {
    pattern_noise_ = last.pattern;
    shear_noise_ = last.shear;
  }
  armed_ = true;
  compared_ = blocks_.blocks_in(kSureFrames);
  held_normal_ = normal_of(0);
  suspicious_ = 0;
  moved_ = moved_before_ = 0;
}

std::optional<Sliding> SlidingDetector::judge_loaded() noexcept {
  if (blocks_.size() < 2) return std::nullopt;
  if (settled_normal_ == 0 && settled(kChanged)) take_reference();
  if (armed_) return judge_armed();
  if (!settled(relaxed_)) return Sliding::disturbed;
  arm();
  return Sliding::none;
}

std::optional<Sliding> SlidingDetector::judge_armed() noexcept {
  const double normal = normal_of(0);
  const bool slid = slides(now_);
  if (normal < (slid ? 1 / kBeyondUsual : options_.opened_below) * held_normal_ ||
      normal > options_.gripped_above * held_normal_) {
    if (normal > options_.gripped_above * settled_normal_) settled_normal_ = 0;  // gripped anew
    armed_ = false;
    return Sliding::disturbed;
  }
  if (slid) {
    if (!settled(kChanged)) return now_;
    arm();
    return Sliding::none;
  }
  compared_ = std::min({compared_ + 1, blocks_.blocks_in(options_.compared_blocks), blocks_.size() - 1});
  const Change change = change_since(compared_);
  const double moved = change.pattern - kPatternPerLogNormal * std::fabs(change.log_normal);
  const double limit = std::max(options_.sticking_pattern, noise_factor_ * pattern_noise_);
  moved_before_ = std::exchange(moved_, std::max(0.0, moved / limit));
  suspicious_ = moved > limit ? suspicious_ + 1 : 0;
  if (suspicious_ >= options_.confirming_blocks || moved > 2 * limit) return kind_since(compared_);
  if (suspicious_ == 0) {
    const Change last = change_since(1);
    pattern_noise_ += (last.pattern - pattern_noise_) / options_.follow_blocks;
    shear_noise_ += (last.shear - shear_noise_) / options_.follow_blocks;
    held_normal_ += (normal - held_normal_) / options_.follow_blocks;
  }
  const bool disturbed = suspicious_ > 0 || std::fabs(change.log_normal) > relaxed_ ||
                         change.shear > std::max(kChanged, noise_factor_ * shear_noise_);
  return disturbed ? Sliding::disturbed : Sliding::none;
}

// The straight line through each channel's blocks: its net change against the blocks' scatter about it, which
// has vibration, jolts and noise, and against the noise alone.
std::optional<Sliding> SlidingDetector::judge_raw() noexcept {
  const std::size_t n = blocks_.size();
  if (n < options_.compared_blocks) return std::nullopt;
  const auto count = static_cast<double>(n);
  const double squared_times = count * (count * count - 1) / 12;
  const std::size_t channels = 3 * blocks_.cells();
  double net_squares = 0, scatter_squares = 0;
  for (std::size_t c = 0; c < channels; ++c) {
    const auto first = static_cast<double>(blocks_.block(0)[c]);  // offsets are large: differences from one
    double sum = 0, squares = 0, moment = 0;
    for (std::size_t ago = 0; ago < n; ++ago) {
      const double value = static_cast<double>(blocks_.block(ago)[c]) - first;
      sum += value;
      squares += value * value;
      moment += value * ((count - 1) / 2 - static_cast<double>(ago));
    }
    const double slope = moment / squared_times;
    net_squares += slope * slope * (count - 1) * (count - 1);
    scatter_squares += std::max(0.0, squares - sum * sum / count - slope * moment);
  }
  const double noise_squares = static_cast<double>(channels) * blocks_.noise() * blocks_.noise();
  if (!(noise_squares > 0)) return std::nullopt;
  if (net_squares < options_.disturbed_noises * options_.disturbed_noises * noise_squares)
    return Sliding::none;
  const double scatter = std::sqrt(scatter_squares / (count - 2) + noise_squares);
  const double limit = slides(now_) ? trend_limit_ / 2 : trend_limit_;
  if (n < TaxelBlocks::kKept || std::sqrt(net_squares) < limit * scatter) return Sliding::disturbed;
  return slides(now_) ? now_ : kind_since(n - 1);
}

}  // namespace slipd
