#include "core/friction/traction_ratio.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/frame/significance.hpp"
#include "core/health/usual.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/norm.hpp"
#include "core/numeric/running_mean.hpp"
#include "core/reading/method/friction_prior.hpp"

namespace slipd {
namespace {

constexpr double kLeastLoad = 1e-9;  // |Q|/P: keeps a quotient finite without shear

}  // namespace

void TractionRatioFilter::update(const ContactPatch& patch) noexcept {
  const MeanSigma ratio{patch.shear_n / patch.normal_n, patch.shear_sigma_n / patch.normal_n};
  // The first frame, and each of a sensor without noise, stands for itself.
  const bool alone = state_.line.frames == 0 || !(ratio.sigma > 0);
  const double gain = alone ? 1 : kSlowGain;
  state_.mean += gain * (ratio.mean - state_.mean);
  state_.normal_n += gain * (patch.normal_n - state_.normal_n);
  state_.shear.x_n += gain * (patch.shear_x_n - state_.shear.x_n);
  state_.shear.y_n += gain * (patch.shear_y_n - state_.shear.y_n);
  const double residual = ratio.mean - (state_.level + state_.line.slope);
  const bool begins = alone || !(std::fabs(residual) < options_.jump_sigmas * ratio.sigma);
  frame_ = {.now = begins ? restart_line(ratio) : extend_line(residual, ratio.sigma),
            .sigma = ratio.sigma,
            .normal_sigma_n = sigma_of_mean(kSlowGain) * patch.normal_sigma_n};
  state_.level = frame_.now.mean;
}

MeanSigma TractionRatioFilter::restart_line(const MeanSigma& frame) noexcept {
  state_.line = {.slope = 0, .frames = 1, .residual = 0};
  return frame;
}

// Least squares over n frames, the newest counted in: its gain is 2 (2n - 1)/(n (n + 1)) for the level, which
// is also the share of one frame's variance that is left in it, and 6/(n (n + 1)) for the slope. A frame
// scatters about the line through the n before it by sigma sqrt((n + 1)(n + 2)/(n (n - 1))).
MeanSigma TractionRatioFilter::extend_line(double residual, double sigma) noexcept {
  Line& line = state_.line;
  const double expected = state_.level + line.slope;
  if (line.frames > options_.frames_after_turn) {
    const double n = line.frames, scatter = sigma * std::sqrt((n + 1) * (n + 2) / (n * (n - 1)));
    line.residual += kQuickGain * (residual / scatter - line.residual);
    if (std::fabs(line.residual) > kClearSigmas * sigma_of_mean(kQuickGain)) {
      line.frames = options_.frames_after_turn;
      line.residual = 0;
    }
  }
  line.frames = std::min(line.frames + 1, learning_frames());
  const double n = line.frames, level_gain = 2 * (2 * n - 1) / (n * (n + 1)), slope_gain = 6 / (n * (n + 1));
  line.slope += slope_gain * residual;
  const double lag = std::max(0.0, std::fabs(line.residual) - sigma_of_mean(kQuickGain));
  const double level = std::max(0.0, expected + level_gain * residual);
  // Noise across a small shear makes |Q| larger, and no mean takes that away: by sigma^2/(2 |Q|), or by
  // sqrt(pi/2) sigma without shear (Rice 1944).
  const double rectified =
      std::min(std::sqrt(std::numbers::pi / 2), 0.5 * sigma / std::max(level, kLeastLoad));
  return {level, norm(std::sqrt(level_gain), norm(lag, rectified)) * sigma};
}

MeanSigma TractionRatioFilter::held() const noexcept {
  return {state_.mean,
          std::max(sigma_of_mean(kSlowGain) * frame_.sigma, options_.held_floor_mean * frame_.now.mean)};
}

bool TractionRatioFilter::is_highest(double load, double sigma) const noexcept {
  return load > state_.highest - kAlikeSigmas * sigma;
}

// Whether the resultant points as it did then.
bool TractionRatioFilter::is_steady(const Shear& since) const noexcept {
  const Shear& now = state_.shear;
  const double along = since.x_n * now.x_n + since.y_n * now.y_n;
  const double across = since.x_n * now.y_n - since.y_n * now.x_n;
  if (along == 0 && across == 0) return true;  // no direction
  const double noise_rad = kAlikeSigmas * frame_.sigma / std::max(state_.mean, kLeastLoad);
  return std::fabs(std::atan2(across, along)) < std::asin(kTurned) + noise_rad;
}

std::optional<TractionRatioFilter::Slide> TractionRatioFilter::detect_slide(
    const SlidingVerdict& sliding) noexcept {
  const auto [ratio, sigma] = frame_.now;
  state_.highest = std::max(state_.highest, ratio - sigma);
  if (state_.normal_n >
      (1 + options_.plateau) * state_.at_last_grip_rise.normal_n + kClearSigmas * frame_.normal_sigma_n)
    state_.at_last_grip_rise = {ratio, state_.normal_n};
  const std::optional<Slide> even = read_plateau();
  if (sliding.field.known && sliding.field.coherence < kWhole) return std::nullopt;
  if (sliding.sliding == Sliding::rotation) return std::nullopt;
  if (sliding.field.known && sliding.sliding == Sliding::translation) return read_moving(sliding);
  state_.moving.reset();
  return even;
}

std::optional<TractionRatioFilter::Slide> TractionRatioFilter::read_moving(
    const SlidingVerdict& sliding) noexcept {
  if (state_.block == sliding.field.block) return std::nullopt;
  state_.block = sliding.field.block;
  if (!state_.moving || !is_steady(*state_.moving)) {
    state_.moving.reset();
    if (state_.mean > 0) state_.moving = state_.shear;
    return std::nullopt;
  }
  return Slide{state_.mean, kKnownFrictionSpread};
}

std::optional<TractionRatioFilter::Slide> TractionRatioFilter::read_plateau() noexcept {
  const double ratio = frame_.now.mean, sigma = frame_.now.sigma;
  const auto even_since = [&](const Plateau& since) {
    return std::fabs(ratio - since.load.ratio) < options_.plateau * since.load.ratio + kAlikeSigmas * sigma &&
           state_.normal_n <= since.load.normal_n && is_steady(since.shear);
  };
  if (!state_.plateau || !even_since(*state_.plateau)) {
    state_.plateau.reset();
    if (ratio > 0) state_.plateau = {.load = {ratio, state_.normal_n}, .shear = state_.shear};
    return std::nullopt;
  }
  const double began_n = state_.plateau->load.normal_n,
               fallen_n = began_n - state_.normal_n - kClearSigmas * frame_.normal_sigma_n;
  if (fallen_n < options_.plateau_fall * began_n) return std::nullopt;
  if (ratio < kFallen * state_.highest) return std::nullopt;
  // A grip that overshoots and relaxes keeps the load that it had at its greatest P.
  if (kFallen * ratio < state_.at_last_grip_rise.ratio + kAlikeSigmas * sigma) return std::nullopt;
  return Slide{ratio, kKnownFrictionSpread};
}

}  // namespace slipd
