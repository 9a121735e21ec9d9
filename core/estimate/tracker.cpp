#include "core/estimate/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slipd {
namespace {

constexpr double kSceneSpread = 0.15;  // in log mu: how softly the scene's range ends
constexpr double kGivenSpread = 0.05;  // the same of a friction known beforehand
constexpr double kKnown = 0.3;         // relative: a friction more open than that is not told
constexpr double kJustChanged = 0.2;   // of a margin while friction is anew to be found
constexpr double kClearly = 2.5;       // standard deviations

}  // namespace

Tracker::Tracker(const EstimatorSettings& settings, Range friction_expected, std::optional<double> friction,
                 bool few_taxels)
    : settings_(settings),
      few_taxels_(few_taxels),
      friction_filter_(friction ? Range{*friction, *friction} : friction_expected,
                       friction ? kGivenSpread : kSceneSpread, few_taxels) {}

// What the frames up to this one say of its margin; nullopt if they contradict all that slipd knows of
// contacts.
std::optional<Tracker::Margin> Tracker::track(const ContactPatch& patch, const FrameEstimate* frame_estimate,
                                              Method method, Estimate& out) noexcept {
  friction_filter_.update(out.time_ns, patch, frame_estimate);
  if (!friction_filter_.understood()) return std::nullopt;
  const auto [load, load_sigma] = friction_filter_.load();
  const auto friction = friction_filter_.weights().friction();
  if (friction.sigma < kKnown * friction.mean) {
    out.friction = friction.mean;
    out.friction_sigma = friction.sigma;
  }
  Margin margin = friction_filter_.weights().margin(load, load_sigma);
  const bool shaped = frame_estimate != nullptr && (!few_taxels_ || frame_estimate->profile.known);
  if (!shaped) {
    // Forces alone never show how near slip is until it has come: of what may be, the less safe part is told.
    margin.mean = std::max(0.0, margin.mean - margin.sigma);
    margin.sigma *= std::numbers::sqrt2;
    return margin;
  }
  if (few_taxels_) return margin;
  if (friction_filter_.doubted()) margin.sigma = std::max(margin.sigma, kJustChanged);
  if (friction_filter_.surprised()) {
    // Friction that fell is felt at once in a frame that tells its margin by itself, in the belief a few
    // frames later.
    if (!frame_estimate->in_model) {
      margin.sigma = std::max(margin.sigma, kJustChanged);
    } else if (frame_estimate->gamma < margin.mean) {
      out.method = method;
      margin = {frame_estimate->gamma, frame_estimate->sigma};
    }
  } else if (frame_estimate->in_model && friction_filter_.monotonic() &&
             std::fabs(frame_estimate->gamma - margin.mean) <
                 kClearly * std::hypot(frame_estimate->sigma, margin.sigma)) {
    out.method = method;
    if (frame_estimate->sigma < margin.sigma) margin = {frame_estimate->gamma, frame_estimate->sigma};
  }
  return margin;
}

void Tracker::update(const ContactPatch& patch, const FrameEstimate* frame_estimate, Method method,
                     Estimate& out) noexcept {
  std::optional<Margin> margin;
  out.method = Method::friction;
  if (settings_.tracking) {
    margin = track(patch, frame_estimate, method, out);
  } else if (frame_estimate != nullptr && frame_estimate->in_model) {
    out.method = method;
    margin = Margin{frame_estimate->gamma, frame_estimate->sigma};
    if (std::isfinite(frame_estimate->friction_sigma)) {
      out.friction = frame_estimate->friction;
      out.friction_sigma = frame_estimate->friction_sigma;
    }
  }
  if (margin && margin->sigma <= settings_.sigma_max) {
    out.state = State::ok;
    out.gamma = margin->mean;
    out.sigma = margin->sigma;
  } else {
    out.state = margin || frame_estimate == nullptr ? State::learning : State::out_of_model;
  }
}

}  // namespace slipd
