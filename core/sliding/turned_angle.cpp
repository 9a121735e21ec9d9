#include "core/sliding/turned_angle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/frame/pause.hpp"
#include "core/frame/significance.hpp"
#include "core/health/usual.hpp"
#include "core/numeric/norm.hpp"
#include "core/numeric/running_mean.hpp"
#include "core/patch/hertz_deviation.hpp"
#include "core/sliding/sliding.hpp"

namespace slipd {
namespace {

// Frames whose mean is the pattern that angles are counted from: as many as a running mean of kQuickGain is
// of.
const int kMeanFrames = static_cast<int>(1 / kQuickGain);

// Timers jitter: a frame this much early is looked at.
constexpr std::int64_t kEarlyNs = 500'000;

std::int64_t duration_ns(double seconds) noexcept {
  return static_cast<std::int64_t>(seconds * 1e9);
}

// A pattern that has not turned after the contact slid under its torque for as long as a contact takes to
// settle belongs to the sensor.
double pinned_s() noexcept {
  return kSureFrames * kBlock_s;
}

}  // namespace

TurnFollower::TurnFollower(const TaxelLayout& layout, const TurnedAngleOptions& options)
    : options_(options), side_m_(layout.side_m()), can_(layout.size() > 1) {}

void TurnFollower::forget() noexcept {
  frames_ = 0;
  begun_ = ended_ = pinned_ = false;
  angle_rad_ = 0;
  slides_since_ns_.reset();
  answer_.reset();
}

TurnFollower::Pattern TurnFollower::pattern_of(const ContactPatch& patch) const noexcept {
  std::array<double, kOrders> real{}, imaginary{}, squares{};
  double load = 0;
  const double scale = 1 / patch.radius_m;
  patch.for_each_inside([&](std::uint32_t i) {
    const double x = scale * (static_cast<double>(patch.taxels.x_m[i]) - patch.center_x_m);
    const double y = scale * (static_cast<double>(patch.taxels.y_m[i]) - patch.center_y_m);
    const auto p = static_cast<double>(patch.taxels.normal_pa[i]);
    const double r2 = x * x + y * y, two_x = x * x - y * y, two_y = 2 * x * y;
    real[0] += p * two_x;
    imaginary[0] += p * two_y;
    real[1] += p * (two_x * x - two_y * y);
    imaginary[1] += p * (two_x * y + two_y * x);
    real[2] += p * (two_x * two_x - two_y * two_y);
    imaginary[2] += p * 2 * two_x * two_y;
    load += p * r2;
    squares[0] += r2 * r2;
    squares[1] += r2 * r2 * r2;
    squares[2] += r2 * r2 * r2 * r2;
  });
  Pattern pattern;
  if (!(load > 0)) return pattern;
  for (std::size_t m = 0; m < kOrders; ++m) {
    pattern.moments[m] = {real[m] / load, imaginary[m] / load};
    pattern.noise[m] = patch.noise_normal_pa * std::sqrt(squares[m] / 2) / load;
  }
  return pattern;
}

// Follows the pattern, and sums up the one that angles are counted from once the grip has closed.
void TurnFollower::take(const ContactPatch& patch, bool settled) noexcept {
  const Pattern pattern = pattern_of(patch);
  const double share = begun_ ? kQuickGain : 1;
  begun_ = true;
  const double quieter = sigma_of_mean(kQuickGain);
  for (std::size_t m = 0; m < kOrders; ++m) {
    newest_.moments[m] += share * (pattern.moments[m] - newest_.moments[m]);
    newest_.noise[m] = pattern.noise[m] * quieter;
  }
  if (!settled || frames_ == kMeanFrames) return;
  if (frames_ == 0) reference_ = {};
  ++frames_;
  for (std::size_t m = 0; m < kOrders; ++m) {
    reference_.moments[m] += (pattern.moments[m] - reference_.moments[m]) / static_cast<double>(frames_);
    reference_.noise[m] = pattern.noise[m] / std::sqrt(static_cast<double>(frames_));
  }
}

// Each moment gives an angle up to multiples of its own symmetry; the one nearest to the last angle is taken.
// A change of the moment's length may come with as large a change of its direction.
std::optional<TurnedAngle> TurnFollower::compare(double rim) const noexcept {
  std::array<double, kOrders> angles{}, weights{};
  double weight = 0, sum = 0;
  std::size_t clear = 0;
  for (std::size_t m = 0; m < kOrders; ++m) {
    const double arms = kLeastArms + static_cast<double>(m);
    const double now = std::abs(newest_.moments[m]), then = std::abs(reference_.moments[m]);
    const double now_sigma = norm(newest_.noise[m], rim);
    const double then_sigma = norm(reference_.noise[m], rim);
    if (now < kStandsOutSigmas * now_sigma || then < kStandsOutSigmas * then_sigma) continue;
    const double turn = std::arg(newest_.moments[m] * std::conj(reference_.moments[m])) / arms;
    const double period = 2 * std::numbers::pi / arms;
    angles[m] = turn + period * std::round((angle_rad_ - turn) / period);
    const double variance = now_sigma * now_sigma / (now * now) + then_sigma * then_sigma / (then * then) +
                            (now - then) * (now - then) / (now * then);
    weights[m] = arms * arms / variance;
    weight += weights[m];
    sum += weights[m] * angles[m];
    ++clear;
  }
  if (clear == 0) return std::nullopt;
  TurnedAngle found{.angle_rad = sum / weight, .sigma_rad = 1 / std::sqrt(weight)};
  if (clear > 1) {  // moments that disagree: the pattern did not only turn
    double squares = 0;
    for (std::size_t m = 0; m < kOrders; ++m)
      squares += weights[m] * (angles[m] - found.angle_rad) * (angles[m] - found.angle_rad);
    found.sigma_rad *= std::sqrt(std::max(1.0, squares / static_cast<double>(clear - 1)));
  }
  return found;
}

// Whether the contact slid and turned while its pattern did not turn: the pattern is the sensor's own, or the
// object is symmetric.
bool TurnFollower::pinned(std::int64_t time_ns, const TurnedAngle& now, bool slides_turning) noexcept {
  if (pinned_ && std::fabs(now.angle_rad - pinned_angle_rad_) > (kClearSigmas + 1) * now.sigma_rad)
    pinned_ = false;
  if (!slides_turning) {
    slides_since_ns_.reset();
    return pinned_;
  }
  if (!slides_since_ns_) {
    slides_since_ns_ = time_ns;
    if (!pinned_) pinned_angle_rad_ = now.angle_rad;
  }
  if (time_ns - *slides_since_ns_ > duration_ns(pinned_s()) &&
      std::fabs(now.angle_rad - pinned_angle_rad_) < kClearSigmas * now.sigma_rad)
    pinned_ = true;
  return pinned_;
}

std::optional<TurnedAngle> TurnFollower::update(std::int64_t time_ns, const ContactPatch& patch, bool settled,
                                                bool slides_turning) noexcept {
  if (!can_ || ended_ || !(patch.radius_m > 0)) return std::nullopt;
  if (begun_ && time_ns - looked_ns_ < duration_ns(options_.spacing_s) - kEarlyNs) return answer_;
  looked_ns_ = time_ns;
  answer_.reset();
  const bool counting = frames_ == kMeanFrames;
  if (counting && time_ns - known_ns_ > duration_ns(kPause_s)) ended_ = true;
  // What lies beyond the sensor's edge turns as well.
  if (ended_ || patch.cut) return std::nullopt;
  take(patch, settled);
  if (frames_ < kMeanFrames) return std::nullopt;
  if (!counting) known_ns_ = time_ns;
  const double coarse = side_m_ / patch.radius_m;
  auto now = compare(kRimShare * coarse * coarse * coarse);
  if (!now || now->sigma_rad > options_.max_sigma_rad) return std::nullopt;
  // How far the followed pattern lags behind one that turns evenly.
  const double lag = (1 - kQuickGain) / kQuickGain * (now->angle_rad - angle_rad_);
  angle_rad_ = now->angle_rad;
  now->sigma_rad = norm(now->sigma_rad, lag);
  known_ns_ = time_ns;
  const bool sharp = now->sigma_rad <= options_.max_sigma_rad;
  if (!pinned(time_ns, *now, slides_turning) && sharp) answer_ = now;
  return answer_;
}

}  // namespace slipd
