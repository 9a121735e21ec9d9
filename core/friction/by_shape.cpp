#include "core/friction/by_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/friction/foundations/monotonic_contact.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

double square(double x) noexcept {
  return x * x;
}

}  // namespace

FrictionByShape::FrictionByShape(const FrictionPrior& prior, const FrictionFilterOptions& options)
    : FrictionFilter(prior, options.foundations, options),
      forces_(options.forces),
      foundations_(grid().frictions()) {}

void FrictionByShape::reset() noexcept {
  reset_evidence();
  forces_.reset();
  foundations_.clear();
  grasp_ = {};
  frame_ = {};
}

void FrictionByShape::lose_sight() noexcept {
  reset();
  history_.lose(HistoryEvent::unseen);
}

void FrictionByShape::update(const FrictionFrame& frame) noexcept {
  const ContactPatch& patch = frame.patch;
  const Reading* const reading = frame.reading;
  begin_frame(frame);
  bound_by_held();
  const bool turning = frame.step.now.under_torque;
  frame_ = {.turning = turning};
  if (!turning) follow(patch, frame.step.before().under_torque);
  const bool clear = reading != nullptr && patch.shear_n > kStrongSigmas * patch.shear_sigma_n;
  verify(frame, clear);
  if (clear && (turning ? weigh_torque(*reading) : weigh_frame(frame))) grasp_.unverified_frames = 0;
  // Nothing that sticks again shows friction, but it may show that friction is not as it was learnt.
  const double most = (1 + kClearSigmas * kUnevenShare) * likeliest();
  if (clear && turning && reading->load_fallen && reading->friction < most) grasp_.unverified_frames = 0;
  // A friction that has just become so has the contact that the likeliest one made, as far as it holds that.
  const std::size_t before = grid().likeliest();
  if (posterior_.conclude())
    foundations_.take_over(before, [this](std::size_t j) { return posterior_.has_changed(j); });
}

void FrictionByShape::follow(const ContactPatch& patch, bool was_turning) noexcept {
  // Under a torque the axis rested.
  if (forces_.aim(patch)) {
    foundations_.assume_monotonic(foundations_.normal_n(), patch.shear_n);
    if (!was_turning) FrictionFilter::lose_history(HistoryEvent::shear_turned);
  }
  const SignedLoad load = forces_.follow(patch, {foundations_.normal_n(), foundations_.asked_n()});
  foundations_.follow(load.normal_n, load.shear_n);
  if (was_turning) {  // what a torque left in the contact is not known; friction is
    history_.lose(HistoryEvent::shear_turned);
    grasp_.margin_offset = {};
    foundations_.assume_monotonic(load.normal_n, load.shear_n);
  }
  if (forces_.loaded_at_onset(patch)) lose_history(HistoryEvent::loaded_at_onset);
}

void FrictionByShape::lose_history(HistoryEvent why) noexcept {
  FrictionFilter::lose_history(why);
  foundations_.assume_monotonic(foundations_.normal_n(), foundations_.asked_n());
}

// Gamma is read from S/Q = 5/3 - rho, so that a slip moment that is larger than a monotonic load's by dS
// reads as a margin that is smaller by dGamma/drho dS/Q.
FrictionByShape::HistoryOffset FrictionByShape::offset_of(std::size_t friction, double load,
                                                          double normal_n) const noexcept {
  const double limit_n = grid().friction(friction) * normal_n, shear_n = load * normal_n;
  const MonotonicContact monotonic = monotonic_contact(shear_n / limit_n);
  const double beyond_n = std::copysign(1.0, foundations_.shear_n(friction)) *
                              foundations_.shear_moments(friction).slip_moment_n -
                          limit_n * monotonic.slip_moment;
  const double resolved_n = options_.monotonic_share_of_limit * limit_n;
  const double per_newton = monotonic.gamma_per_moment_ratio / shear_n;
  return {beyond_n, per_newton * std::copysign(std::max(0.0, std::fabs(beyond_n) - resolved_n), beyond_n),
          per_newton * resolved_n};
}

bool FrictionByShape::looks_monotonic(double normal_n, double load) noexcept {
  const std::size_t j = grid().likeliest();
  const double limit_n = grid().friction(j) * normal_n;
  const HistoryOffset offset = offset_of(j, load, normal_n);
  grasp_.margin_offset = {offset.margin, norm(options_.offset_sigma_share * offset.margin,
                                              grasp_.other_history ? offset.unresolved : 0)};
  return std::fabs(offset.beyond_n) <
         options_.monotonic_share_of_shear * load * normal_n + options_.monotonic_share_of_limit * limit_n;
}

bool FrictionByShape::weigh_frame(const FrictionFrame& frame) noexcept {
  const ContactPatch& patch = frame.patch;
  const Reading& reading = *frame.reading;
  history_.classify(looks_monotonic(patch.normal_n, patch.shear_n / patch.normal_n));
  grasp_.other_history |= !is_monotonic(history());
  // What taxels make of traction that a heavier load has locked in stays while the load falls.
  const contact::ShearMoments& common = reading.moments_common_sigma;
  contact::ShearMoments& locked_in = grasp_.locked_in_sigma;
  if (is_monotonic(history())) locked_in = {};
  locked_in = {std::max(locked_in.slip_moment_n, common.slip_moment_n),
               std::max(locked_in.second_legendre_n, common.second_legendre_n)};
  const bool by_margin = is_monotonic(history()) && reading.in_model;
  const bool has_moments = is_known(history()) && std::isfinite(reading.moments_sigma.slip_moment_n);
  const bool margin_explained = by_margin && compare_margin(patch, reading);
  if (!has_moments) return margin_explained;
  const bool moments_explained = compare_moments(patch, reading, by_margin);
  return by_margin ? margin_explained : moments_explained;
}

// A frame whose field a torque has changed shows friction itself, by taxels that slip, whatever the history.
bool FrictionByShape::weigh_torque(const Reading& reading) noexcept {
  grasp_.margin_offset = {};
  if (!reading.in_model || !std::isfinite(reading.friction_sigma)) return false;
  const double all = reading.friction_sigma / reading.friction;
  const double common = std::min(all, reading.common_sigma / (1 - reading.gamma));
  const double variance = square(all) + variance_of_step(2 * grid().step());
  PerFriction residuals;  // the first grid().count() of them
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < grid().count(); ++j) {
    residuals[j] = std::log(reading.friction / grid().friction(j));
    least = std::min(least, square(residuals[j]) / variance);
  }
  const bool explained = explain(least, false);
  posterior_.weigh(Evidence::torque, residuals, norm(common, std::sqrt(variance_of_step(grid().step()))),
                   std::sqrt(square(all) - square(common)));
  return explained;
}

bool FrictionByShape::compare_margin(const ContactPatch& patch, const Reading& reading) noexcept {
  // All frictions expect their margins of one load: a frame's noise in it would be a larger error of those
  // that are low, and over a long hold the frictions with the smallest errors would win.
  const ContactForces& steady = forces_.steady().now();
  const double load = norm(steady.shear_x_n, steady.shear_y_n) / steady.normal_n;
  if (reading.profile.known) {
    weigh_profile(reading.profile, load);
    return explain(0, reading.sigma < options_.confirming_sigma);
  }
  PerFriction residuals;  // the first grid().count() of them
  PosteriorSums offsets;
  for (std::size_t j = 0; j < grid().count(); ++j) {
    const double offset = offset_of(j, load, patch.normal_n).margin;
    offsets.add(grid().weight(j), offset);
    const double expected = std::max(0.0, 1 - load / grid().friction(j)) - offset;
    residuals[j] = reading.gamma - std::clamp(expected, 0.0, 1.0);  // more than full slip is not read
  }
  // Frictions that may be right have contacts of other histories.
  MeanSigma& own = grasp_.margin_offset;
  const double offset_sigma = own.sigma;
  own.sigma = std::sqrt(square(own.sigma) + offsets.variance() + square(offsets.mean() - own.mean));
  const double utilisation = std::min(1.0, load / likeliest());
  const double variance =
      square(reading.sigma) + square(offset_sigma) + variance_of_step(2 * grid().step() * utilisation);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < grid().count(); ++j) least = std::min(least, square(residuals[j]) / variance);
  const bool explained = explain(least, reading.sigma < options_.confirming_sigma);
  weigh_margin(residuals, reading, offset_sigma, utilisation);
  return explained;
}

bool FrictionByShape::compare_moments(const ContactPatch& patch, const Reading& reading,
                                      bool followed_only) noexcept {
  const contact::ShearMoments &seen = reading.moments, &all = reading.moments_sigma,
                              &own = reading.moments_common_sigma, &locked_in = grasp_.locked_in_sigma;
  const double sign = forces_.axis().cosine(patch);
  // The model's error is the same in every frame.
  const double most_n = std::max(std::fabs(seen.slip_moment_n), std::fabs(seen.second_legendre_n));
  const double model_n = norm(kUnevenShare * patch.shear_n, options_.locked_in_share * most_n);
  const contact::ShearMoments common{norm(locked_in.slip_moment_n, model_n),
                                     norm(locked_in.second_legendre_n, model_n)};
  const contact::ShearMoments noise{
      std::sqrt(std::max(0.0, square(all.slip_moment_n) - square(own.slip_moment_n))),
      std::sqrt(std::max(0.0, square(all.second_legendre_n) - square(own.second_legendre_n)))};
  PerFriction slip, legendre;  // the first grid().count() of them
  double least = std::numeric_limits<double>::infinity();
  const double slip_variance = square(common.slip_moment_n) + square(noise.slip_moment_n),
               legendre_variance = square(common.second_legendre_n) + square(noise.second_legendre_n);
  for (std::size_t j = 0; j < grid().count(); ++j) {
    const auto expected = foundations_.shear_moments(j);
    slip[j] = seen.slip_moment_n - sign * expected.slip_moment_n;
    legendre[j] = seen.second_legendre_n - sign * expected.second_legendre_n;
    least =
        std::min(least, std::max(square(slip[j]) / slip_variance, square(legendre[j]) / legendre_variance));
  }
  if (followed_only) {
    posterior_.follow(Evidence::slip_moment, slip, common.slip_moment_n, noise.slip_moment_n);
    posterior_.follow(Evidence::second_legendre, legendre, common.second_legendre_n, noise.second_legendre_n);
    return true;
  }
  const bool explained = explain(least, false);
  posterior_.weigh(Evidence::slip_moment, slip, common.slip_moment_n, noise.slip_moment_n);
  posterior_.weigh(Evidence::second_legendre, legendre, common.second_legendre_n, noise.second_legendre_n);
  return explained;
}

// Whether memory may answer. `clear`: the frame's shear is far above the noise.
void FrictionByShape::verify(const FrictionFrame& frame, bool clear) noexcept {
  if (clear) {
    grasp_.shear_lost = false;
    ++grasp_.unverified_frames;
    return;
  }
  const double limit_n = likeliest() * frame.patch.normal_n;
  const double moved_n = frame.step.shear_moved_n();
  const std::optional<Load>& before = frame.step.previous;
  const bool was_clear = before && before->ratio().mean > kStrongSigmas * before->ratio_sigma;
  if (was_clear && frame.patch.shear_n < moved_n && kGrown * moved_n > limit_n) grasp_.shear_lost = true;
}

}  // namespace slipd
