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
      belief_(friction ? Range{*friction, *friction} : friction_expected,
              friction ? kGivenSpread : kSceneSpread, few_taxels) {}

// What the frames up to this one say of its margin; nullopt if they contradict all that slipd knows of
// contacts.
std::optional<Tracker::Margin> Tracker::track(const ContactPatch& patch, const Reading* reading,
                                              Method method, Estimate& out) noexcept {
  belief_.update(out.time_ns, patch, reading);
  if (!belief_.understood()) return std::nullopt;
  const auto [load, load_sigma] = belief_.load();
  const auto friction = belief_.weights().friction();
  if (friction.sigma < kKnown * friction.mean) {
    out.friction = friction.mean;
    out.friction_sigma = friction.sigma;
  }
  Margin margin = belief_.weights().margin(load, load_sigma);
  const bool shaped = reading != nullptr && (!few_taxels_ || reading->profile.known);
  if (!shaped) {
    // Forces alone never show how near slip is until it has come: of what may be, the less safe part is told.
    margin.mean = std::max(0.0, margin.mean - margin.sigma);
    margin.sigma *= std::numbers::sqrt2;
    return margin;
  }
  if (few_taxels_) return margin;
  if (belief_.doubted()) margin.sigma = std::max(margin.sigma, kJustChanged);
  if (belief_.surprised()) {
    // Friction that fell is felt at once in a frame that tells its margin by itself, in the belief a few
    // frames later.
    if (!reading->in_family) {
      margin.sigma = std::max(margin.sigma, kJustChanged);
    } else if (reading->gamma < margin.mean) {
      out.method = method;
      margin = {reading->gamma, reading->sigma};
    }
  } else if (reading->in_family && belief_.only_risen() &&
             std::fabs(reading->gamma - margin.mean) < kClearly * std::hypot(reading->sigma, margin.sigma)) {
    out.method = method;
    if (reading->sigma < margin.sigma) margin = {reading->gamma, reading->sigma};
  }
  return margin;
}

void Tracker::update(const ContactPatch& patch, const Reading* reading, Method method,
                     Estimate& out) noexcept {
  std::optional<Margin> margin;
  out.method = Method::friction;
  if (settings_.tracking) {
    margin = track(patch, reading, method, out);
  } else if (reading != nullptr && reading->in_family) {
    out.method = method;
    margin = Margin{reading->gamma, reading->sigma};
    if (std::isfinite(reading->friction_sigma)) {
      out.friction = reading->friction;
      out.friction_sigma = reading->friction_sigma;
    }
  }
  if (margin && margin->sigma <= settings_.sigma_max) {
    out.state = State::ok;
    out.gamma = margin->mean;
    out.sigma = margin->sigma;
  } else {
    out.state = margin || reading == nullptr ? State::learning : State::out_of_model;
  }
}

}  // namespace slipd
