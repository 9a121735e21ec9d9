#include "core/margin/margin_fusion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slipd {
namespace {

// Of sigma_max, what a margin's sigma may be before all that widens it is known.
constexpr double kBelow = 0.95;

FrictionPrior prior_of(Range expected, const std::optional<KnownFriction>& friction,
                       const FrictionPriorOptions& options) {
  if (friction) return {.expected = friction->range, .spread = options.given_spread};
  return {.expected = expected, .spread = options.scene_spread};
}

// The range bounds what is learnt: a grip that relaxes looks like sliding at a friction that no object of the
// scene has.
FrictionFilterOptions bounded(FrictionFilterOptions filter, const std::optional<Range>& range, double slack) {
  if (!range) return filter;
  filter.grid.min_friction = range->low * std::exp(-slack);
  filter.grid.max_friction = range->high * std::exp(slack);
  return filter;
}

// Frames with a shape show friction by themselves: only what was given for this very sensor bounds them.
std::optional<Range> bounds_of(Range expected, const std::optional<KnownFriction>& friction,
                               bool force_only) {
  if (friction) return friction->range;
  return force_only ? std::optional(expected) : std::nullopt;
}

}  // namespace

MarginFusion::MarginFusion(const EstimatorSettings& settings, Range friction_expected,
                           std::optional<KnownFriction> friction, bool force_only,
                           const MarginFusionOptions& options)
    : settings_(settings),
      force_only_(force_only),
      friction_(friction.value_or(friction_expected)),
      given_value_(friction && friction->is_value()),
      bounds_(bounds_of(friction_expected, friction, force_only)),
      options_(options),
      friction_filter_(
          prior_of(friction_expected, friction, options.prior), force_only,
          bounded(options.filter, bounds_, force_only ? options.force_only_slack : options.shaped_slack)),
      prior_(friction_filter_.grid().friction()),
      last_friction_(prior_.mean) {}

void MarginFusion::give_friction(Estimate& out) const noexcept {
  const MeanSigma friction = friction_filter_.grid().friction();
  const double relative = friction.sigma / friction.mean;
  const bool learnt = relative < options_.learnt_share * prior_.sigma / prior_.mean;
  if (!given_value_ && !(learnt && relative < options_.known_sigma)) return;
  out.friction = bounds_ ? std::clamp(friction.mean, bounds_->low, bounds_->high) : friction.mean;
  out.friction_sigma = friction.sigma;
}

void MarginFusion::give_limit(const ContactPatch& patch, Estimate& out) const noexcept {
  if (out.friction) {
    out.limit_n = *out.friction * patch.normal_n;
    out.limit_sigma_n = out.friction_sigma.value_or(0) * patch.normal_n;
    return;
  }
  const MeanSigma inverse = friction_filter_.grid().inverse_friction();
  out.limit_n = patch.normal_n / inverse.mean;
  out.limit_sigma_n = *out.limit_n * inverse.sigma / inverse.mean;
}

// One sigma down, and sigma covers both; of a known range, as far down as sigma_max permits. A value that was
// given leaves nothing open.
MeanSigma MarginFusion::lowered(MeanSigma margin) const noexcept {
  if (given_value_) return margin;
  double down = margin.sigma;
  if (std::log(friction_.range.high / friction_.range.low) <= options_.narrow_range) {
    const double most = kBelow * settings_.sigma_max;
    if (margin.sigma < most) down = std::min(down, std::sqrt(most * most - margin.sigma * margin.sigma));
  }
  return {std::max(0.0, margin.mean - down), std::hypot(margin.sigma, down)};
}

// A posterior too wide for a Gaussian of sigma_max may still lie between bounds that are no farther apart
// than four sigmas, and lower than two. The margin is then its mean less its standard deviation, which is the
// safe side.
MeanSigma MarginFusion::within_bounds(MeanSigma lowered, MeanSigma margin, double load) const noexcept {
  if (!force_only_ || !bounds_ || given_value_ || lowered.sigma <= settings_.sigma_max) return lowered;
  const double sigma = kBelow * settings_.sigma_max;
  const double most = std::max(0.0, 1 - load / bounds_->high), least = std::max(0.0, 1 - load / bounds_->low);
  if (most > 4 * sigma || margin.mean > least + 2 * sigma) return lowered;
  return {std::max(least, lowered.mean), sigma};
}

// Below the load's maximum all sticks: friction may have fallen to what taxels still carry, and nothing shows
// it.
void MarginFusion::widen_by_unseen_fall(double load, const Reading& reading,
                                        MeanSigma& margin) const noexcept {
  if (given_value_) return;
  const double held = std::max(load, reading.friction);
  const double open = margin.mean - (held > 0 ? 1 - load / held : 0);
  margin.sigma = std::hypot(margin.sigma, options_.unseen_fall_share * std::max(0.0, open));
}

// What a pad shows of its margin is the same from frame to frame, errors too, and is not added up. It only
// lowers the margin: rubber that shares its shear evenly until it slides would pass for a pad that sticks.
MeanSigma MarginFusion::margin_at(double load, double load_sigma,
                                  const MarginProfile* shared) const noexcept {
  const MeanSigma by_filter = friction_filter_.grid().margin(load, load_sigma);
  if (shared == nullptr || !shared->known) return by_filter;
  FrictionGrid grid = friction_filter_.grid();
  for (std::size_t j = 0; j < grid.count(); ++j) grid.take(j, shared->at(1 - load / grid.friction(j)));
  grid.normalise();
  const MeanSigma with_shared = grid.margin(load, load_sigma);
  return with_shared.mean < by_filter.mean ? with_shared : by_filter;
}

std::optional<MeanSigma> MarginFusion::track(const ContactPatch& patch, const Reading* reading, Method method,
                                             const SlidingVerdict& course, const MarginProfile* shared,
                                             Estimate& out) noexcept {
  friction_filter_.update(out.time_ns, patch, reading, course);
  // What happened before the frame matters for friction only. Given as a value, it needs neither.
  const bool by_forces = given_value_ && !is_known(friction_filter_.history());
  if (!by_forces && !friction_filter_.understood()) return std::nullopt;
  const bool turning = reading != nullptr && reading->turning;
  const bool by_itself = turning && reading->in_model;  // needs no memory
  if (by_forces || by_itself ? friction_filter_.shear_lost() : !friction_filter_.explained()) {
    if (!is_implausible(out.health)) out.health = Health::unexplained;
    return std::nullopt;
  }
  const auto [load, load_sigma] = friction_filter_.traction_ratio();
  const MeanSigma friction = friction_filter_.grid().friction();
  last_friction_ = friction.mean;
  give_friction(out);
  const double relative = friction.sigma / friction.mean;
  if (turning && !given_value_ && !(relative < options_.frame_known_sigma)) {
    out.friction.reset();
    out.friction_sigma.reset();
  }
  MeanSigma margin = margin_at(load, load_sigma, shared);
  if (bounds_)
    margin.mean = std::clamp(margin.mean, std::max(0.0, 1 - load / bounds_->low),
                             std::max(0.0, 1 - load / bounds_->high));
  margin.sigma = std::hypot(margin.sigma, options_.least_friction_sigma * (1 - margin.mean));
  if (by_itself) {
    // A frame that shows friction by itself has a better value of it than the frames before under a lighter
    // load, whose taxels nearly slipped.
    if (reading->friction_sigma < options_.frame_known_sigma * reading->friction) {
      out.friction = reading->friction;
      out.friction_sigma = reading->friction_sigma;
    }
    return MeanSigma{reading->gamma, reading->sigma};
  }
  if (turning && !given_value_ && !(relative < options_.turning_known_sigma))
    return MeanSigma{margin.mean, std::numeric_limits<double>::infinity()};
  const bool shaped =
      reading != nullptr && (!force_only_ || reading->profile.known) && !turning && !by_forces;
  const bool fallen = friction_filter_.fallen() && friction.sigma > options_.settled_sigma * friction.mean;
  if (!shaped || fallen) {
    // Forces alone never show how near slip is until it has come, nor does one frame how far friction has
    // fallen: the lower part of the posterior is given.
    margin = within_bounds(lowered(margin), margin, load);
    if (shaped && doubted()) margin.sigma = std::max(margin.sigma, options_.doubted_sigma);
    if (reading != nullptr && reading->load_fallen) widen_by_unseen_fall(load, *reading, margin);
    return margin;
  }
  const bool settled = friction.sigma < options_.settled_sigma * friction.mean;
  if (force_only_) return settled ? margin : lowered(margin);
  return combine(margin, *reading, method, out);
}

MeanSigma MarginFusion::combine(MeanSigma margin, const Reading& reading, Method method,
                                Estimate& out) const noexcept {
  const auto [offset, offset_sigma] = friction_filter_.margin_offset();
  const MeanSigma own{std::clamp(reading.gamma + offset, 0.0, 1.0), std::hypot(reading.sigma, offset_sigma)};
  if (doubted()) margin.sigma = std::max(margin.sigma, options_.doubted_sigma);
  if (friction_filter_.surprised() && !given_value_) {
    // A frame of a monotonic load shows friction that fell at once, the filter a few frames later.
    if (!reading.in_model) {
      margin.sigma = std::max(margin.sigma, options_.doubted_sigma);
    } else if (own.mean < margin.mean) {
      out.method = method;
      margin = own;
    }
    return margin;
  }
  if (!reading.in_model || !is_monotonic(friction_filter_.history())) return margin;
  const double sigma = std::hypot(own.sigma, margin.sigma);
  if (!(std::fabs(own.mean - margin.mean) < options_.agreement_sigmas * sigma)) return margin;
  out.method = method;
  return own.sigma < margin.sigma ? own : margin;
}

void MarginFusion::update(const ContactPatch& patch, const Reading* reading, Method method, Estimate& out,
                          const SlidingVerdict& course, const MarginProfile* shared) noexcept {
  std::optional<MeanSigma> margin;
  out.method = Method::friction;
  if (settings_.tracking) {
    margin = track(patch, reading, method, course, shared, out);
  } else if (reading != nullptr && reading->in_model) {
    out.method = method;
    margin = MeanSigma{reading->gamma, reading->sigma};
    if (std::isfinite(reading->friction_sigma)) {
      out.friction = reading->friction;
      out.friction_sigma = reading->friction_sigma;
    }
  }
  if (margin && margin->sigma <= settings_.sigma_max) {
    out.state = State::ok;
    out.gamma = margin->mean;
    out.sigma = std::hypot(margin->sigma, options_.least_sigma);
    if (settings_.tracking) give_limit(patch, out);
  } else {
    out.state = margin || reading == nullptr ? State::learning : State::out_of_model;
  }
}

}  // namespace slipd
