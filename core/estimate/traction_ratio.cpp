#include "core/estimate/traction_ratio.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

// Without shape the load is followed with its slope, by a straight line through all frames since it last
// turned, of these the last kLongest or so. It turned where frames are off to one side: the line begins anew
// with the last few, or with one where the load jumped.
constexpr int kLongest = 30, kAfterTurn = 6;
constexpr double kAstray = 0.25, kTurn = 1.15;  // gain of a mean of deviations, three deviations of that
constexpr double kJump = 4;                     // deviations
constexpr double kMeanGain = 0.1, kMeanSigma = 0.23;  // of its mean, and that's deviation over one frame's
constexpr double kHighest = 2;                        // deviations by which a load may miss the highest one
constexpr double kPlateauChange = 0.06;               // of P, so much less of it makes a plateau one
constexpr double kFallen = 4;                         // deviations of P besides

}  // namespace

// Gains of least squares over n frames, the newest first counted in: 2 (2n - 1)/(n (n + 1)) for the level,
// which is also the share of one frame's variance that is left in it, and 6/(n (n + 1)) for the slope.
void TractionRatioFilter::update(const ContactPatch& patch) noexcept {
  const double load = patch.shear_n / patch.normal_n, sigma = patch.shear_sigma_n / patch.normal_n;
  const bool first = frame_sigma_ == 0;
  const double gain = first ? 1 : kMeanGain;
  mean_ += gain * (load - mean_);
  normal_n_ = {normal_n_.mean + gain * (patch.normal_n - normal_n_.mean), kMeanSigma * patch.normal_sigma_n};
  frame_sigma_ = sigma;
  const double expected = now_.mean + change_, off = load - expected;
  if (!force_only_ || first || !(std::fabs(off) < kJump * sigma)) {
    now_ = {load, sigma};
    change_ = astray_ = 0;
    frames_ = 1;
    return;
  }
  if (frames_ > kAfterTurn) {
    const double n = frames_,
                 scatter = sigma * std::sqrt((n + 1) * (n + 2) / (n * (n - 1)));  // of a frame about the line
    astray_ += kAstray * (off / scatter - astray_);
    if (std::fabs(astray_) > kTurn) {
      frames_ = kAfterTurn;
      astray_ = 0;
    }
  }
  frames_ = std::min(frames_ + 1, kLongest);
  const double n = frames_, level = 2 * (2 * n - 1) / (n * (n + 1)), slope = 6 / (n * (n + 1));
  change_ += slope * off;
  const double lag = std::max(0.0, std::fabs(astray_) - kTurn / 3);
  now_ = {std::max(0.0, expected + level * off), std::hypot(std::sqrt(level), lag) * sigma};
}

TractionRatioFilter::Held TractionRatioFilter::held() const noexcept {
  if (!force_only_) return {{now_.mean, std::max(now_.sigma, 0.01 * now_.mean)}, 1};
  return {{mean_, std::max(kMeanSigma * frame_sigma_, 0.005 * now_.mean)}, kMeanGain};
}

bool TractionRatioFilter::is_highest(double load, double sigma) const noexcept {
  return load > highest_ - kHighest * sigma;
}

std::optional<double> TractionRatioFilter::look_for_sliding() noexcept {
  const auto [load, sigma] = now_;
  highest_ = std::max(highest_, load - sigma);
  const bool even = std::fabs(load - slide_load_) < kPlateau * slide_load_ + 2 * sigma;
  if (!even || slide_load_ == 0 || normal_n_.mean > slide_normal_n_) {
    slide_load_ = load;
    slide_normal_n_ = normal_n_.mean;
    return std::nullopt;
  }
  const double fallen_n = slide_normal_n_ - normal_n_.mean - kFallen * normal_n_.sigma;
  if (fallen_n < kPlateauChange * slide_normal_n_ || load < 0.9 * highest_) return std::nullopt;
  return load;
}

}  // namespace slipd
