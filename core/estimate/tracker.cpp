#include "core/estimate/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slipd {
namespace {

FrictionPrior prior_of(Range expected, std::optional<double> friction, const FrictionPriorOptions& options) {
  if (friction) return {.expected = {*friction, *friction}, .spread = options.given_spread};
  return {.expected = expected, .spread = options.scene_spread};
}

// The scene's range, and a friction that was given, bound what is learnt from forces alone: a grip that
// relaxes looks like a slide at a friction that no object of the scene has.
FrictionFilterOptions bounded(FrictionFilterOptions filter, const FrictionPrior& prior, bool force_only,
                              double slack) {
  if (!force_only) return filter;
  filter.grid.min_friction = std::max(filter.grid.min_friction, prior.expected.low * std::exp(-slack));
  filter.grid.max_friction = std::min(filter.grid.max_friction, prior.expected.high * std::exp(slack));
  return filter;
}

}  // namespace

Tracker::Tracker(const EstimatorSettings& settings, Range friction_expected, std::optional<double> friction,
                 bool force_only, const TrackerOptions& options)
    : settings_(settings),
      force_only_(force_only),
      options_(options),
      friction_filter_(prior_of(friction_expected, friction, options.prior), force_only,
                       bounded(options.filter, prior_of(friction_expected, friction, options.prior),
                               force_only, options.bound_slack)) {}

std::optional<MeanSigma> Tracker::track(const ContactPatch& patch, const FrameEstimate* frame_estimate,
                                        Method method, Estimate& out) noexcept {
  friction_filter_.update(out.time_ns, patch, frame_estimate);
  if (!friction_filter_.understood()) return std::nullopt;
  if (!friction_filter_.explained()) {
    if (out.health == Health::good) out.health = Health::unexplained;
    return std::nullopt;
  }
  const auto [load, load_sigma] = friction_filter_.traction_ratio();
  const MeanSigma friction = friction_filter_.grid().friction();
  if (friction.sigma < options_.known_sigma * friction.mean) {
    out.friction = friction.mean;
    out.friction_sigma = friction.sigma;
  }
  MeanSigma margin = friction_filter_.grid().margin(load, load_sigma);
  if (frame_estimate != nullptr && frame_estimate->turning && frame_estimate->in_model) {
    // A frame that shows friction by itself knows it better than the lighter ones before it, whose taxels
    // nearly slipped.
    out.friction = frame_estimate->friction;
    out.friction_sigma = frame_estimate->friction_sigma;
    return MeanSigma{frame_estimate->gamma, frame_estimate->sigma};
  }
  const bool shaped = frame_estimate != nullptr && (!force_only_ || frame_estimate->profile.known) &&
                      !frame_estimate->turning;
  const bool fallen = friction_filter_.fallen() && friction.sigma > options_.settled_sigma * friction.mean;
  if (!shaped || fallen) {
    // Forces alone never show how near slip is until it has come, nor does one frame how far friction has
    // fallen: the lower part of the posterior is given, one sigma down, and sigma covers both.
    margin.mean = std::max(0.0, margin.mean - margin.sigma);
    margin.sigma *= std::numbers::sqrt2;
    if (shaped && friction_filter_.doubted()) margin.sigma = std::max(margin.sigma, options_.doubted_sigma);
    return margin;
  }
  if (force_only_) return margin;
  return combine(margin, *frame_estimate, method, out);
}

MeanSigma Tracker::combine(MeanSigma margin, const FrameEstimate& frame_estimate, Method method,
                           Estimate& out) const noexcept {
  const auto [offset, offset_sigma] = friction_filter_.margin_offset();
  const MeanSigma own{std::clamp(frame_estimate.gamma + offset, 0.0, 1.0),
                      std::hypot(frame_estimate.sigma, offset_sigma)};
  if (friction_filter_.doubted()) margin.sigma = std::max(margin.sigma, options_.doubted_sigma);
  if (friction_filter_.surprised()) {
    // A frame of a monotonic load shows friction that fell at once, the filter a few frames later.
    if (!frame_estimate.in_model) {
      margin.sigma = std::max(margin.sigma, options_.doubted_sigma);
    } else if (own.mean < margin.mean) {
      out.method = method;
      margin = own;
    }
    return margin;
  }
  if (!frame_estimate.in_model || !is_monotonic(friction_filter_.history())) return margin;
  const double sigma = std::hypot(own.sigma, margin.sigma);
  if (!(std::fabs(own.mean - margin.mean) < options_.agreement_sigmas * sigma)) return margin;
  out.method = method;
  return own.sigma < margin.sigma ? own : margin;
}

void Tracker::update(const ContactPatch& patch, const FrameEstimate* frame_estimate, Method method,
                     Estimate& out) noexcept {
  std::optional<MeanSigma> margin;
  out.method = Method::friction;
  if (settings_.tracking) {
    margin = track(patch, frame_estimate, method, out);
  } else if (frame_estimate != nullptr && frame_estimate->in_model) {
    out.method = method;
    margin = MeanSigma{frame_estimate->gamma, frame_estimate->sigma};
    if (std::isfinite(frame_estimate->friction_sigma)) {
      out.friction = frame_estimate->friction;
      out.friction_sigma = frame_estimate->friction_sigma;
    }
  }
  if (margin && margin->sigma <= settings_.sigma_max) {
    out.state = State::ok;
    out.gamma = margin->mean;
    out.sigma = std::hypot(margin->sigma, options_.least_sigma);
  } else {
    out.state = margin || frame_estimate == nullptr ? State::learning : State::out_of_model;
  }
}

}  // namespace slipd
