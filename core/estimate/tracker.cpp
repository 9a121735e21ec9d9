#include "core/estimate/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slipd {
namespace {

constexpr double kRiseAfterSeconds = 0.5;  // a higher friction is believed in over about this time
constexpr double kLeastSigma = 0.02;       // of a belief, relative: contacts are not as even as their model
constexpr double kGivenSigma = 0.05;       // relative, of a friction known beforehand
constexpr double kSliding = 0.1;           // a margin below which the whole contact may as well stick
constexpr double kKnown = 0.3;             // relative: a friction more open than that is not told
constexpr double kClearly = 2.5;           // standard deviations

}  // namespace

// Two independent words on one margin.
Tracker::Margin Tracker::fuse(const Margin& a, const Margin& b) noexcept {
  const double wa = 1 / (a.sigma * a.sigma + 1e-12), wb = 1 / (b.sigma * b.sigma + 1e-12);
  return {(wa * a.gamma + wb * b.gamma) / (wa + wb), 1 / std::sqrt(wa + wb)};
}

bool Tracker::agree(const Margin& a, const Margin& b) noexcept {
  return std::fabs(a.gamma - b.gamma) < kClearly * std::hypot(a.sigma, b.sigma) + 0.01;
}

Tracker::Tracker(const EstimatorSettings& settings, Range friction_expected, std::optional<double> friction,
                 bool few_taxels)
    : settings_(settings), expected_(friction_expected) {
  if (friction) given_ = Belief{*friction, kGivenSigma * *friction};
  belief_ = given_;
  if (few_taxels) {
    grid_.emplace(friction ? Range{*friction * (1 - kGivenSigma), *friction * (1 + kGivenSigma)}
                           : friction_expected);
  }
}

void Tracker::forget() noexcept {
  belief_ = given_;
  growth_.reset();
  if (grid_) grid_->reset();
}

void Tracker::learn(double friction, double sigma, std::int64_t time_ns) noexcept {
  const double passed_s = static_cast<double>(time_ns - learnt_ns_) * 1e-9;
  // What lies far off all that the scene expects is a mistake of the reading more often than an object.
  const bool expected = friction > 0.7 * expected_.low && friction < 1.4 * expected_.high;
  if (!expected || !(sigma < 0.3 * friction)) return;
  learnt_ns_ = time_ns;
  sigma = std::max(sigma, kLeastSigma * friction);
  if (!belief_) {
    belief_ = Belief{friction, sigma};
    return;
  }
  const double difference = friction - belief_->mean;
  if (difference < -kClearly * std::hypot(sigma, belief_->sigma)) {
    belief_ = Belief{friction, sigma};
    return;
  }
  const double gain = belief_->sigma * belief_->sigma / (belief_->sigma * belief_->sigma + sigma * sigma);
  const double most_rise = belief_->mean * std::clamp(passed_s / kRiseAfterSeconds, 0.0, 0.1);
  belief_->mean += std::min(gain * difference, most_rise);
  belief_->sigma = std::max(belief_->sigma * std::sqrt(1 - gain), kLeastSigma * belief_->mean);
}

// What can be said without this object's friction, from the friction that the scene expects: much while the
// load is light.
Tracker::Margin Tracker::from_scene(double load, double load_sigma) const noexcept {
  const double low = std::clamp(1 - (load + load_sigma) / expected_.low, 0.0, 1.0);
  const double high = std::clamp(1 - std::max(0.0, load - load_sigma) / expected_.high, 0.0, 1.0);
  return {0.5 * (low + high), (high - low) / std::sqrt(12.0)};
}

Tracker::Margin Tracker::from_belief(double load, double load_sigma) const noexcept {
  const double mobilised = load / belief_->mean;
  return {std::clamp(1 - mobilised, 0.0, 1.0),
          std::hypot(mobilised * belief_->sigma / belief_->mean, load_sigma / belief_->mean)};
}

// Nowhere is more friction mobilised than at a slipping rim, so its ratio is at least the whole contact's.
bool Tracker::rim_slips(const RimReading& rim, double load, double load_sigma) const noexcept {
  return rim.even && std::fabs(rim.ratio) > load - 3 * load_sigma - 0.02 * load &&
         !growth_.explains(rim.ratio, rim.sigma);
}

void Tracker::update_few(const ContactPatch& patch, const Reading* reading, Estimate& out) noexcept {
  const double load = patch.shear_n / patch.normal_n, load_sigma = patch.shear_sigma_n / patch.normal_n;
  grid_->update(out.time_ns, patch.normal_n, load, load_sigma,
                reading != nullptr ? &reading->profile : nullptr);
  auto margin = grid_->margin(load, load_sigma);
  const auto friction = grid_->belief();
  if (reading == nullptr || !reading->profile.known) {
    // Forces alone never show how near slip is until it has come: of what may be, the less safe part is told.
    margin.mean = std::max(0.0, margin.mean - margin.sigma);
    margin.sigma *= std::numbers::sqrt2;
  }
  out.method = Method::friction;
  if (friction.sigma < kKnown * friction.mean) {
    out.friction = friction.mean;
    out.friction_sigma = friction.sigma;
  }
  out.state = State::learning;
  if (margin.sigma > settings_.sigma_max) return;
  out.state = State::ok;
  out.gamma = margin.mean;
  out.sigma = margin.sigma;
}

void Tracker::update(const ContactPatch& patch, const Reading* reading, Method method,
                     Estimate& out) noexcept {
  if (grid_ && settings_.tracking) {
    update_few(patch, reading, out);
    return;
  }
  const double load = patch.shear_n / patch.normal_n;
  const double load_sigma = patch.shear_sigma_n / patch.normal_n;
  growth_.update(out.time_ns, patch.normal_n, patch.shear_n);
  // A contact that sticks all over while both forces grew looks like one that slides: neither is told from
  // the other.
  const bool direct =
      reading != nullptr && reading->in_family &&
      !(reading->gamma < kSliding && growth_.explains(reading->friction, reading->friction_sigma));
  std::optional<Margin> margin;
  out.method = direct ? method : Method::friction;
  if (direct) margin = Margin{reading->gamma, reading->sigma};

  if (settings_.tracking) {
    if (direct) {
      learn(reading->friction, reading->friction_sigma, out.time_ns);
    } else if (reading != nullptr && rim_slips(reading->rim, load, load_sigma)) {
      learn(std::fabs(reading->rim.ratio), reading->rim.sigma, out.time_ns);
    }
    // Friction is never less than what it is seen to hold.
    if (belief_ && load - 3 * load_sigma > belief_->mean) belief_->mean = load - 3 * load_sigma;
    if (belief_) {
      const Margin remembered = from_belief(load, load_sigma);
      if (!margin || (!agree(*margin, remembered) && margin->gamma > remembered.gamma)) {
        margin = remembered;
      } else if (agree(*margin, remembered)) {
        margin = fuse(*margin, remembered);
      }
    }
  }
  if (!margin || margin->sigma > settings_.sigma_max) {
    const Margin expected = from_scene(load, load_sigma);
    if (expected.sigma < settings_.sigma_max && (!margin || expected.sigma < margin->sigma))
      margin = expected;
  }

  if (belief_) {
    out.friction = belief_->mean;
    out.friction_sigma = belief_->sigma;
  } else if (direct && std::isfinite(reading->friction_sigma)) {
    out.friction = reading->friction;
    out.friction_sigma = reading->friction_sigma;
  }
  if (margin && margin->sigma <= settings_.sigma_max) {
    out.state = State::ok;
    out.gamma = margin->gamma;
    out.sigma = margin->sigma;
  } else {
    out.state = margin || reading == nullptr ? State::learning : State::out_of_model;
  }
}

}  // namespace slipd
