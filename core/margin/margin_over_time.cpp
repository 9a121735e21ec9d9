#include "core/margin/margin_over_time.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/friction/by_forces.hpp"
#include "core/friction/by_pillars.hpp"
#include "core/friction/by_shape.hpp"
#include "core/numeric/norm.hpp"
#include "core/reading/method/friction_prior.hpp"
#include "core/reading/torque/torque_moment_ratio.hpp"

namespace slipd {
namespace {

// Of sigma_max, what a margin's sigma may be before all that widens it is known.
constexpr double kBelow = 0.95;
constexpr Range kUnbounded{0, std::numeric_limits<double>::infinity()};

FrictionPrior prior_of(const FrictionKnowledge& friction, const FrictionPriorOptions& options) {
  return {.expected = friction.range(),
          .spread = friction.given ? kKnownFrictionSpread : options.scene_spread};
}

// The range bounds what is learnt: a grip that relaxes looks like sliding at a friction that no object of the
// scene has.
FrictionFilterOptions bounded(FrictionFilterOptions filter, const Range& range, double slack) {
  if (!(range.low > 0)) return filter;
  filter.posterior.grid.min_friction = range.low * std::exp(-slack);
  filter.posterior.grid.max_friction = range.high * std::exp(slack);
  return filter;
}

// Frames with a shape show friction by themselves: only what was given for this very sensor bounds them.
Range shaped_bounds(const FrictionKnowledge& friction) {
  return friction.given ? friction.given->range : kUnbounded;
}

std::unique_ptr<FrictionFilter> by_forces(const FrictionKnowledge& friction,
                                          const MarginOverTimeOptions& options) {
  return std::make_unique<FrictionByForces>(prior_of(friction, options.prior),
                                            bounded(options.filter, friction.range(), kUnevenShare));
}

std::unique_ptr<FrictionFilter> by_shape(const FrictionKnowledge& friction,
                                         const MarginOverTimeOptions& options) {
  return std::make_unique<FrictionByShape>(
      prior_of(friction, options.prior),
      bounded(options.filter, shaped_bounds(friction), kKnownFrictionSpread));
}

std::unique_ptr<FrictionFilter> by_pillars(const TaxelLayout& layout, const FrictionKnowledge& friction,
                                           const MarginOverTimeOptions& options) {
  return std::make_unique<FrictionByPillars>(
      layout, prior_of(friction, options.prior),
      bounded(options.filter, shaped_bounds(friction), kKnownFrictionSpread));
}

}  // namespace

MarginOverTime::MarginOverTime(double sigma_max, Range bounds, std::unique_ptr<FrictionFilter> filter,
                               const MarginOverTimeOptions& options)
    : options_(options),
      sigma_max_(sigma_max),
      bounds_(bounds),
      filter_(std::move(filter)),
      prior_(filter_->grid().friction()),
      last_friction_(prior_.mean) {}

double MarginOverTime::common_sigma(const MarginInput& frame) const noexcept {
  return std::max(options_.least_friction_sigma, filter_->common_sigma(frame.acting));
}

MarginOverTime::Now MarginOverTime::now_with(MeanSigma margin, const MarginInput& frame) noexcept {
  const MeanSigma load = filter_->traction_ratio(), friction = filter_->grid().friction();
  margin.mean = std::clamp(margin.mean, std::max(0.0, 1 - load.mean / bounds_.low),
                           std::max(0.0, 1 - load.mean / bounds_.high));
  margin.sigma = norm(margin.sigma, common_sigma(frame) * (1 - margin.mean));
  last_friction_ = friction.mean;
  return {load, friction, margin};
}

void MarginOverTime::rely_on_least(const MarginInput& frame, MarginDecision& decision) const noexcept {
  decision.rely_on(std::max(bounds_.low, filter_->grid().least_friction(common_sigma(frame))));
}

void MarginOverTime::refuse_contradicted(const MarginInput& frame, MarginDecision& decision,
                                         Estimate& out) noexcept {
  if (!is_implausible(out.health)) out.health = Health::unexplained;
  refuse_unknown(frame, decision);
}

void MarginOverTime::refuse_unknown(const MarginInput& frame, MarginDecision& decision) noexcept {
  decision.refuse(frame.reading == nullptr ? State::learning : State::out_of_model);
}

void MarginOverTime::give_friction(const MeanSigma& friction, Estimate& out) const noexcept {
  out.friction = std::clamp(friction.mean, bounds_.low, bounds_.high);
  out.friction_sigma = friction.sigma;
}

void MarginOverTime::propose(const MeanSigma& margin, const MarginInput& frame, MarginDecision& decision,
                             Estimate& out) const noexcept {
  decision.propose(margin);
  if (!(margin.sigma <= sigma_max_)) return;
  if (out.friction) {
    out.limit_n = *out.friction * frame.acting.normal_n;
    out.limit_sigma_n = out.friction_sigma.value_or(0) * frame.acting.normal_n;
    return;
  }
  const MeanSigma inverse = filter_->grid().inverse_friction();
  out.limit_n = frame.acting.normal_n / inverse.mean;
  out.limit_sigma_n = *out.limit_n * inverse.sigma / inverse.mean;
}

// It has a better value of friction than the frames before under a lighter load, whose taxels nearly slipped.
MeanSigma MarginOverTime::by_itself(const Reading& reading, MarginDecision& decision,
                                    Estimate& out) const noexcept {
  if (reading.friction_sigma < kSettledFriction * reading.friction) {
    out.friction = reading.friction;
    out.friction_sigma = reading.friction_sigma;
    decision.rely_on(reading.friction - kOneSided95 * reading.friction_sigma);
  }
  return {reading.gamma, reading.sigma};
}

MeanSigma MarginOverTime::own_margin(const Reading& reading) const noexcept {
  const auto [offset, offset_sigma] = filter_->margin_offset();
  return {std::clamp(reading.gamma + offset, 0.0, 1.0), norm(reading.sigma, offset_sigma)};
}

MeanSigma MarginOverTime::better_of(const MeanSigma& margin, const MeanSigma& own, const Reading& reading,
                                    Estimate& out) const noexcept {
  if (!reading.in_model || !is_monotonic(filter_->history())) return margin;
  const double sigma = norm(own.sigma, margin.sigma);
  if (!(std::fabs(own.mean - margin.mean) < kClearSigmas * sigma)) return margin;
  out.method = reading.by;
  return own.sigma < margin.sigma ? own : margin;
}

// --- friction that is learnt

LearntFrictionMargin::LearntFrictionMargin(double sigma_max, const FrictionKnowledge& friction, Range bounds,
                                           std::unique_ptr<FrictionFilter> filter,
                                           const MarginOverTimeOptions& options)
    : MarginOverTime(sigma_max, bounds, std::move(filter), options),
      log_range_(std::log(friction.range().high / friction.range().low)),
      usual_friction_(std::sqrt(friction.range().low * friction.range().high)) {}

std::optional<MarginOverTime::Now> LearntFrictionMargin::learn(const MarginInput& frame,
                                                               MarginDecision& decision,
                                                               Estimate& out) noexcept {
  out.method = Method::friction;
  filter_->update({frame.acting, frame.step, frame.reading, frame.previous_sliding});
  if (!filter_->understood()) {
    refuse_unknown(frame, decision);
    return std::nullopt;
  }
  // A frame whose torque shows friction by itself needs no memory.
  const bool alone = frame.step.now.under_torque && frame.reading->in_model;
  if (alone ? filter_->shear_lost() : !filter_->explained()) {
    refuse_contradicted(frame, decision, out);
    return std::nullopt;
  }
  const Now now = now_with(with_shared(filter_->traction_ratio(), frame.shared), frame);
  const bool learnt = now.relative() < options_.learnt_share * prior_.sigma / prior_.mean;
  const double known = frame.step.now.under_torque ? kSettledFriction : kKnownFriction;
  if (learnt && now.relative() < known) give_friction(now.friction, out);
  return now;
}

void LearntFrictionMargin::widen_by_unobserved(const MarginInput& frame, MarginDecision& decision,
                                               const Estimate& out) noexcept {
  unobserved_.update(frame.measured, frame.step, out.friction.value_or(usual_friction_));
  decision.widen(unobserved_.sigma());
}

// What a pad shows of its margin is the same from frame to frame, errors too, and is not added up. It only
// lowers the margin: rubber that shares its shear evenly until it slides would pass for a pad that sticks.
MeanSigma LearntFrictionMargin::with_shared(const MeanSigma& load,
                                            const MarginProfile* shared) const noexcept {
  const MeanSigma by_filter = filter_->grid().margin(load.mean, load.sigma);
  if (shared == nullptr || !shared->known) return by_filter;
  FrictionGrid grid = filter_->grid();
  std::array<double, FrictionGrid::kMost> weights;
  for (std::size_t j = 0; j < grid.count(); ++j)
    weights[j] = grid.weight(j) * std::exp(-shared->at(1 - load.mean / grid.friction(j)));
  grid.assign(weights);
  const MeanSigma with_shared = grid.margin(load.mean, load.sigma);
  return with_shared.mean < by_filter.mean ? with_shared : by_filter;
}

// One sigma down, and sigma covers both; of a narrow range, as far down as sigma_max permits.
MeanSigma LearntFrictionMargin::minus_one_sigma(const Now& now, const MeanSigma& margin) const noexcept {
  double down = std::min(margin.sigma, now.relative() * (1 - margin.mean));
  if (log_range_ <= options_.narrow_range) {
    const double most = kBelow * sigma_max_;
    if (margin.sigma < most) down = std::min(down, std::sqrt(most * most - margin.sigma * margin.sigma));
  }
  return {std::max(0.0, margin.mean - down), norm(margin.sigma, down)};
}

LearntByForces::LearntByForces(double sigma_max, const FrictionKnowledge& friction,
                               const MarginOverTimeOptions& options)
    : LearntFrictionMargin(sigma_max, friction, friction.range(), by_forces(friction, options), options) {}

// Forces alone never show how near slip is until it has come: the lower part of the posterior is given, as
// long as friction has not settled, and only friction that was learnt, or that frames show, is relied on.
void LearntByForces::estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept {
  if (const auto now = learn(frame, decision, out)) {
    const bool shows_margin = frame.reading != nullptr && frame.reading->profile.known;
    if (shows_margin || out.friction) rely_on_least(frame, decision);
    MeanSigma margin = now->margin;
    if (!shows_margin) {
      margin = within_bounds(*now, margin);
    } else if (!has_settled(*now)) {
      margin = minus_one_sigma(*now, margin);
    }
    propose(margin, frame, decision, out);
  }
  widen_by_unobserved(frame, decision, out);
}

// A posterior too wide for a Gaussian of sigma_max may still lie between bounds that are no farther apart
// than four sigmas, and lower than two. The margin is then its mean less its standard deviation, which is the
// safe side.
MeanSigma LearntByForces::within_bounds(const Now& now, const MeanSigma& margin) const noexcept {
  const double load = now.load.mean;
  const MeanSigma low = minus_one_sigma(now, margin);
  if (low.sigma <= sigma_max_) return low;
  const double sigma = kBelow * sigma_max_;
  const double most = std::max(0.0, 1 - load / bounds_.high), least = std::max(0.0, 1 - load / bounds_.low);
  if (most > 4 * sigma || margin.mean > least + 2 * sigma) return low;
  return {std::max(least, low.mean), sigma};
}

LearntByPillars::LearntByPillars(double sigma_max, const TaxelLayout& layout,
                                 const FrictionKnowledge& friction, const MarginOverTimeOptions& options)
    : LearntFrictionMargin(sigma_max, friction, shaped_bounds(friction),
                           by_pillars(layout, friction, options), options) {}

void LearntByPillars::estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept {
  if (const auto now = learn(frame, decision, out)) {
    rely_on_least(frame, decision);
    MeanSigma margin = has_settled(*now) ? now->margin : minus_one_sigma(*now, now->margin);
    if (filter_->surprised()) margin.sigma = std::numeric_limits<double>::infinity();
    propose(margin, frame, decision, out);
  }
  widen_by_unobserved(frame, decision, out);
}

LearntByShape::LearntByShape(double sigma_max, const FrictionKnowledge& friction,
                             const MarginOverTimeOptions& options)
    : LearntFrictionMargin(sigma_max, friction, shaped_bounds(friction), by_shape(friction, options),
                           options) {}

void LearntByShape::estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept {
  if (const auto now = learn(frame, decision, out)) {
    rely_on_least(frame, decision);
    const Reading* const reading = frame.reading;
    const bool torque = frame.step.now.under_torque;
    MeanSigma margin;
    if (torque && reading->in_model) {
      margin = by_itself(*reading, decision, out);
    } else if (torque && !(now->relative() < kKnownFriction)) {
      margin = {now->margin.mean, std::numeric_limits<double>::infinity()};
    } else if (reading == nullptr || torque) {
      margin = by_memory(*now, reading);
    } else {
      margin = combine(*now, *reading, out);
    }
    propose(margin, frame, decision, out);
  }
  widen_by_unobserved(frame, decision, out);
}

// Below the load's maximum all sticks under a torque: friction may have fallen to what taxels still carry,
// and nothing shows it.
MeanSigma LearntByShape::by_memory(const Now& now, const Reading* reading) const noexcept {
  MeanSigma margin = minus_one_sigma(now, now.margin);
  if (reading == nullptr) return margin;
  if (reading->load_fallen) {
    const double held = std::max(now.load.mean, reading->friction);
    const double open = margin.mean - (held > 0 ? 1 - now.load.mean / held : 0);
    margin.sigma = norm(margin.sigma, options_.unseen_fall_share * std::max(0.0, open));
  }
  return margin;
}

MeanSigma LearntByShape::combine(const Now& now, const Reading& reading, Estimate& out) const noexcept {
  if (filter_->surprised()) return {now.margin.mean, std::numeric_limits<double>::infinity()};
  return better_of(has_settled(now) ? now.margin : minus_one_sigma(now, now.margin), own_margin(reading),
                   reading, out);
}

// --- friction that was given as a value

GivenFrictionMargin::GivenFrictionMargin(double sigma_max, const FrictionKnowledge& friction,
                                         std::unique_ptr<FrictionFilter> filter,
                                         const MarginOverTimeOptions& options)
    : MarginOverTime(sigma_max, friction.range(), std::move(filter), options) {}

std::optional<MarginOverTime::Now> GivenFrictionMargin::follow(const MarginInput& frame,
                                                               MarginDecision& decision, Estimate& out,
                                                               bool& by_forces) noexcept {
  out.method = Method::friction;
  filter_->update({frame.acting, frame.step, frame.reading, frame.previous_sliding});
  by_forces = !is_known(filter_->history());
  if (!by_forces && !filter_->understood()) {
    refuse_unknown(frame, decision);
    return std::nullopt;
  }
  const bool alone = by_forces || (frame.step.now.under_torque && frame.reading->in_model);
  if (alone ? filter_->shear_lost() : !filter_->explained()) {
    refuse_contradicted(frame, decision, out);
    return std::nullopt;
  }
  const MeanSigma load = filter_->traction_ratio();
  const Now now = now_with(filter_->grid().margin(load.mean, load.sigma), frame);
  rely_on_least(frame, decision);
  give_friction(now.friction, out);
  return now;
}

GivenByForces::GivenByForces(double sigma_max, const FrictionKnowledge& friction,
                             const MarginOverTimeOptions& options)
    : GivenFrictionMargin(sigma_max, friction, by_forces(friction, options), options) {}

void GivenByForces::estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept {
  bool alone = false;
  if (const auto now = follow(frame, decision, out, alone)) propose(now->margin, frame, decision, out);
}

GivenByShape::GivenByShape(double sigma_max, const FrictionKnowledge& friction,
                           const MarginOverTimeOptions& options)
    : GivenFrictionMargin(sigma_max, friction, by_shape(friction, options), options) {}

void GivenByShape::estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept {
  bool alone = false;
  const auto now = follow(frame, decision, out, alone);
  if (!now) return;
  const Reading* const reading = frame.reading;
  MeanSigma margin = now->margin;
  if (frame.step.now.under_torque) {
    if (reading->in_model) margin = by_itself(*reading, decision, out);
  } else if (reading != nullptr && !alone) {
    margin = better_of(margin, own_margin(*reading), *reading, out);
  }
  propose(margin, frame, decision, out);
}

std::unique_ptr<MarginSource> make_margin_over_time(double sigma_max, const FrictionKnowledge& friction,
                                                    bool needs_history,
                                                    const MarginOverTimeOptions& options) {
  const bool given = friction.given && friction.given->is_value();
  if (given && needs_history) return std::make_unique<GivenByForces>(sigma_max, friction, options);
  if (given) return std::make_unique<GivenByShape>(sigma_max, friction, options);
  if (needs_history) return std::make_unique<LearntByForces>(sigma_max, friction, options);
  return std::make_unique<LearntByShape>(sigma_max, friction, options);
}

std::unique_ptr<MarginSource> make_margin_of_pillars(double sigma_max, const TaxelLayout& layout,
                                                     const FrictionKnowledge& friction,
                                                     const MarginOverTimeOptions& options) {
  if (friction.given && friction.given->is_value())
    return std::make_unique<GivenByForces>(sigma_max, friction, options);
  return std::make_unique<LearntByPillars>(sigma_max, layout, friction, options);
}

}  // namespace slipd
