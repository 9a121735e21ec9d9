#include "core/friction/friction_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/reading/moments/moments.hpp"

namespace slipd {
namespace {

constexpr double kSecondsPerNs = 1e-9;

// The slip moment Q (5/3 - 5/2 <u>_q) after a monotonic load, over mu P: with Gamma = k^3 it is
// 5/3 (1 - k^3) - (1 - k^5). (docs/theory.md §7)
double monotonic_slip_moment(double gamma) noexcept {
  const double k = std::cbrt(std::clamp(gamma, 0.0, 1.0)), k3 = k * k * k;
  return 5.0 / 3 * (1 - k3) - (1 - k3 * k * k);
}

double square(double x) noexcept {
  return x * x;
}

}  // namespace

FrictionFilter::FrictionFilter(const FrictionPrior& prior, bool force_only,
                               const FrictionFilterOptions& options)
    : options_(options),
      force_only_(force_only),
      grid_(prior, force_only ? options.force_only_points : options.foundations, options.grid),
      traction_ratio_(force_only, options.traction_ratio),
      forces_(options.forces),
      history_(options.history),
      foundations_(grid_.frictions().first(std::min(grid_.count(), options.foundations))) {}

void FrictionFilter::reset() noexcept {
  grid_.reset();
  traction_ratio_.reset();
  forces_.reset();
  history_.contact_lost();
  foundations_.clear();
  grasp_ = {};
}

void FrictionFilter::update(std::int64_t time_ns, const ContactPatch& patch, const Reading* reading,
                            const SlidingVerdict& course) noexcept {
  traction_ratio_.update(patch);
  fade(time_ns);
  if (force_only_) {
    forget_lighter(patch);
    watch_hook();
  }
  const bool tangled =
      force_only_ && (grasp_.hooked || course.field.internal_share > options_.max_internal_share);
  if (!tangled) bound_below();
  const bool turning = reading != nullptr && reading->turning;
  if (!force_only_ && !turning) follow(patch);
  grasp_.turning = turning;
  grasp_.surprised = false;
  grasp_.doubt_frames = std::max(0, grasp_.doubt_frames - 1);
  const bool clear = reading != nullptr && patch.shear_n > options_.min_shear_sigmas * patch.shear_sigma_n;
  if (!force_only_) verify(patch, clear);
  if (!clear || turning) grasp_.slip_moment.known = false;
  if (clear && (turning ? weigh_turning(patch, *reading) : weigh_frame(patch, *reading))) {
    grasp_.unverified_frames = 0;
  }
  // Nothing that sticks again shows friction, but it may show that friction is not as it was learnt.
  if (clear && turning && reading->load_fallen &&
      reading->friction < options_.held_ratio * grid_.friction(grid_.likeliest()))
    grasp_.unverified_frames = 0;
  if (force_only_) {
    if (const auto slide = traction_ratio_.detect_slide(course); slide && !tangled) weigh_slide(*slide);
  }
  grid_.normalise();
  if (!force_only_) doubt_jump();
}

// Evidence of forces alone grows old.
void FrictionFilter::fade(std::int64_t time_ns) noexcept {
  const double passed_s =
      grasp_.last_ns > 0 ? static_cast<double>(time_ns - grasp_.last_ns) * kSecondsPerNs : 0;
  grasp_.last_ns = time_ns;
  if (force_only_) grid_.fade(std::exp(-std::max(0.0, passed_s) / options_.forget_s));
}

void FrictionFilter::forget_lighter(const ContactPatch& patch) noexcept {
  if (patch.normal_n <= options_.grown * grasp_.lighter_n) return;
  if (grasp_.lighter_n > 0) grid_.fade(options_.kept_when_grown);
  grasp_.lighter_n = patch.normal_n;
}

// More than the greatest expected friction holds: something hooks. What the load showed of friction while it
// rose to that is forgotten.
void FrictionFilter::watch_hook() noexcept {
  const MeanSigma load = traction_ratio_.held().load;
  const double highest = grid_.friction(grid_.count() - 1), lowest = grid_.friction(0);
  if (load.mean - options_.hooked_sigmas * load.sigma > options_.hooked * highest) grasp_.hooked = true;
  if (!grasp_.hooked) return;
  grid_.reset();
  grasp_.hooked = load.mean > lowest;
}

// Coulomb: friction is at least the |Q|/P that it holds.
void FrictionFilter::bound_below() noexcept {
  const auto [load, frames] = traction_ratio_.held();
  for (std::size_t j = 0; j < grid_.count(); ++j) {
    const double over = (load.mean - grid_.friction(j)) / load.sigma;
    if (over > 0) grid_.take(j, frames * 0.5 * over * over);
  }
}

void FrictionFilter::follow(const ContactPatch& patch) noexcept {
  // Under a torque the axis rested.
  if (forces_.aim(patch) && !grasp_.turning) lose_history(HistoryEvent::shear_turned);
  if (forces_.follow(patch)) foundations_.follow(forces_.normal_n(), forces_.shear_n());
  if (grasp_.turning) {  // what a torque left in the contact is not known; friction is
    history_.lose(HistoryEvent::shear_turned);
    grasp_.margin_offset = {};
    foundations_.assume_monotonic(forces_.normal_n(), forces_.shear_n());
  }
  if (forces_.loaded_at_onset(patch)) lose_history(HistoryEvent::loaded_at_onset);
}

void FrictionFilter::lose_history(HistoryEvent why) noexcept {
  history_.lose(why);
  grid_.reset();
  forget_common();
  if (!force_only_) foundations_.assume_monotonic(forces_.normal_n(), forces_.shear_n());
}

// Gamma is read from S/Q = 5/3 - rho, so that a slip moment that is larger than a monotonic load's by dS
// reads as a margin that is smaller by dGamma/drho dS/Q.
MeanSigma FrictionFilter::offset_of(std::size_t friction, double load, double normal_n) const noexcept {
  const double mu = grid_.friction(friction), limit_n = mu * normal_n, shear_n = load * normal_n;
  const double gamma = std::clamp(1 - load / mu, 0.0, 1.0);
  const double off_n =
      std::fabs(foundations_.shear_moments(friction).slip_moment_n) - limit_n * monotonic_slip_moment(gamma);
  const double resolved_n = options_.monotonic_share_of_limit * limit_n;
  const double per_newton = gamma_per_moment_ratio(gamma) / shear_n;
  const double clear = per_newton * std::copysign(std::max(0.0, std::fabs(off_n) - resolved_n), off_n);
  return {clear, std::hypot(options_.offset_sigma_share * clear,
                            grasp_.other_history ? per_newton * resolved_n : 0)};
}

bool FrictionFilter::looks_monotonic(double normal_n, double load) noexcept {
  const std::size_t j = grid_.likeliest();
  const double mu = grid_.friction(j), limit_n = mu * normal_n;
  const double monotonic_n = limit_n * monotonic_slip_moment(1 - load / mu);
  grasp_.margin_offset = offset_of(j, load, normal_n);
  return std::fabs(std::fabs(foundations_.shear_moments(j).slip_moment_n) - monotonic_n) <
         options_.monotonic_share_of_shear * load * normal_n + options_.monotonic_share_of_limit * limit_n;
}

bool FrictionFilter::weigh_frame(const ContactPatch& patch, const Reading& reading) noexcept {
  const double load = patch.shear_n / patch.normal_n;
  history_.classify(force_only_ ? traction_ratio_.is_highest(load, patch.shear_sigma_n / patch.normal_n)
                                : looks_monotonic(patch.normal_n, load));
  grasp_.other_history |= !is_monotonic(history());
  const contact::ShearMoments& common = reading.moments_common_sigma;
  contact::ShearMoments& locked_in = grasp_.locked_in_sigma;
  if (is_monotonic(history())) locked_in = {};
  locked_in = {std::max(locked_in.slip_moment_n, common.slip_moment_n),
               std::max(locked_in.second_legendre_n, common.second_legendre_n)};
  const bool as_monotonic = is_monotonic(history()) && reading.in_model;
  if (!force_only_ && is_known(history())) detect_fall(patch, reading);
  PerFriction residuals;  // the first grid_.count() of them
  if (as_monotonic) {
    compare_margin(patch, reading, residuals);
    grasp_.discount.add(reading.sigma / options_.alike_sigma);
  } else if (is_known(history()) && !force_only_ && std::isfinite(reading.moments_sigma.slip_moment_n)) {
    compare_moments(patch, reading, residuals);
  } else {
    return false;
  }
  part_errors(patch);
  return take_evidence(residuals, as_monotonic && reading.sigma < options_.confirming_sigma,
                       as_monotonic ? share_of_margin(load, reading) : share_of_moments(patch, reading));
}

// A frame whose torque has bent the field shows friction itself, by taxels that slip, whatever the history.
bool FrictionFilter::weigh_turning(const ContactPatch& patch, const Reading& reading) noexcept {
  grasp_.margin_offset = {};
  if (!reading.in_model || !std::isfinite(reading.friction_sigma)) return false;
  part_errors(patch);
  const double all = reading.friction_sigma / reading.friction;
  const double common =
      std::min(all, reading.common_sigma / std::max(options_.min_mobilised, 1 - reading.gamma));
  const double step = options_.grid_share * grid_.step();
  PerFriction residuals;  // the first grid_.count() of them
  for (std::size_t j = 0; j < grid_.count(); ++j)
    residuals[j] = square(std::log(grid_.friction(j) / reading.friction)) / (square(all) + square(step));
  const double noise = std::max(square(all) - square(common), options_.min_noise_share * square(all));
  return take_evidence(residuals, false, grasp_.of_margins.add(square(common), noise));
}

// What frames have in common changes with the contact: where the forces have moved far, errors are new.
void FrictionFilter::part_errors(const ContactPatch& patch) noexcept {
  const double limit_n = grid_.friction(grid_.likeliest()) * patch.normal_n;
  const double moved = std::hypot((patch.normal_n - grasp_.evidence_normal_n) / patch.normal_n,
                                  (patch.shear_n - grasp_.evidence_shear_n) / limit_n);
  const double kept = std::exp(-moved / options_.parting_share);
  grasp_.of_margins.known *= kept;
  grasp_.of_moments.known *= kept;
  grasp_.evidence_normal_n = patch.normal_n;
  grasp_.evidence_shear_n = patch.shear_n;
}

// Of a frame's margin: friction's relative error is Gamma's over 1 - Gamma. The likeliest friction's Gamma:
// by the frame's own, noise that lowers Gamma would weigh more than noise that raises it.
double FrictionFilter::share_of_margin(double load, const Reading& reading) noexcept {
  if (reading.profile.known || !(reading.common_sigma > 0)) return 1;
  const double mobilised = std::clamp(load / grid_.friction(grid_.likeliest()), options_.min_mobilised, 1.0);
  const double all = square(reading.sigma / mobilised), own = square(reading.common_sigma / mobilised),
               usual = grasp_.of_margins.usual(reading.common_sigma, options_.common_gain) / mobilised;
  return grasp_.of_margins.add(square(usual), std::max(all - own, options_.min_noise_share * all));
}

// Of a frame's slip moment, over Q.
double FrictionFilter::share_of_moments(const ContactPatch& patch, const Reading& reading) noexcept {
  const double all = square(with_locked_in(reading).slip_moment_n / patch.shear_n),
               grid = grasp_.locked_in_sigma.slip_moment_n / patch.shear_n,
               usual = grasp_.of_moments.usual(grid, options_.common_gain),
               model = square(options_.model_sigma_share * options_.uneven_share);
  return grasp_.of_moments.add(square(usual) + model,
                               std::max(all - square(grid), options_.min_noise_share * (all + model)));
}

// Errors of the model and of the taxels' size are the same in two frames, so that the step from one to the
// next is known much better than either: where the slip moment grows by more than the forces' step explains,
// friction has fallen.
void FrictionFilter::detect_fall(const ContactPatch& patch, const Reading& reading) noexcept {
  const SlipMoment last = grasp_.slip_moment;
  SlipMoment& now = grasp_.slip_moment;
  if (!std::isfinite(reading.moments_sigma.slip_moment_n)) {
    now.known = false;
    return;
  }
  now = {.known = true,
         .friction = grid_.likeliest(),
         .seen_n = forces_.axis().cosine(patch) * reading.moments.slip_moment_n,
         .expected_n = foundations_.shear_moments(grid_.likeliest()).slip_moment_n,
         .sigma_n = std::sqrt(std::max(0.0, square(reading.moments_sigma.slip_moment_n) -
                                                square(reading.moments_common_sigma.slip_moment_n))),
         .normal_n = patch.normal_n,
         .shear_n = forces_.axis().along_n(patch)};
  if (!last.known || last.friction != now.friction) return;
  const double step_n = (now.seen_n - last.seen_n) - (now.expected_n - last.expected_n);
  const double moved_n = std::fabs(now.shear_n - last.shear_n) +
                         grid_.friction(now.friction) * std::fabs(now.normal_n - last.normal_n);
  const double explained_n = options_.fall_sigmas * std::hypot(now.sigma_n, last.sigma_n) +
                             options_.fall_share_of_step * moved_n + options_.fall_share * patch.shear_n;
  if (!(std::copysign(1.0, now.shear_n) * step_n > explained_n)) return;
  forget_common();
  grasp_.fallen = true;
  grid_.open_below(options_.fallen_nats);
  foundations_.weaken(now.friction, [](std::size_t) { return true; });
  grasp_.doubt_frames = std::max(grasp_.doubt_frames, 1);
}

void FrictionFilter::compare_margin(const ContactPatch& patch, const Reading& reading,
                                    PerFriction& residuals) const noexcept {
  const double step = options_.grid_share * grid_.step(), load = patch.shear_n / patch.normal_n;
  const double frames = options_.frame_share * grasp_.discount.share();
  const bool followed = !force_only_ && (grasp_.other_history || grasp_.margin_offset.mean != 0);
  const std::size_t likeliest = grid_.likeliest();
  for (std::size_t j = 0; j < grid_.count(); ++j) {
    const double mobilised = load / grid_.friction(j);
    const bool near = j + options_.offset_reach >= likeliest && j <= likeliest + options_.offset_reach;
    const MeanSigma offset = followed && near ? offset_of(j, load, patch.normal_n) : grasp_.margin_offset;
    residuals[j] = reading.profile.known
                       ? frames * 2 * reading.profile.at(1 - mobilised - offset.mean)
                       : square(reading.gamma + offset.mean - 1 + mobilised) /
                             (square(reading.sigma) + square(offset.sigma) + square(step * mobilised));
  }
}

void FrictionFilter::compare_moments(const ContactPatch& patch, const Reading& reading,
                                     PerFriction& residuals) noexcept {
  const contact::ShearMoments& seen = reading.moments;
  const contact::ShearMoments noise = with_locked_in(reading);
  const double sign = forces_.axis().cosine(patch);
  // The model's error is the same in every frame: within it a frame distinguishes nothing.
  const double locked_in_n = std::max(std::fabs(seen.slip_moment_n), std::fabs(seen.second_legendre_n));
  const double open_n =
      std::hypot(options_.uneven_share * patch.shear_n, options_.locked_in_share * locked_in_n);
  doubt_likeliest(reading, sign, open_n);

  const double model_variance = square(options_.model_sigma_share * open_n);
  const auto squared = [open_n, model_variance](double off_n, double sigma_n) {
    return square(std::max(0.0, std::fabs(off_n) - open_n)) / (square(sigma_n) + model_variance);
  };
  for (std::size_t j = 0; j < grid_.count(); ++j) {
    const auto expected = foundations_.shear_moments(j);
    residuals[j] =
        squared(seen.slip_moment_n - sign * expected.slip_moment_n, noise.slip_moment_n) +
        squared(seen.second_legendre_n - sign * expected.second_legendre_n, noise.second_legendre_n);
  }
}

// What taxels make of traction that a heavier load has locked in stays while the load falls.
contact::ShearMoments FrictionFilter::with_locked_in(const Reading& reading) const noexcept {
  const contact::ShearMoments &all = reading.moments_sigma, &own = reading.moments_common_sigma,
                              &most = grasp_.locked_in_sigma;
  const auto add = [](double sigma_n, double own_n, double most_n) {
    return std::sqrt(square(sigma_n) + std::max(0.0, square(most_n) - square(own_n)));
  };
  return {add(all.slip_moment_n, own.slip_moment_n, most.slip_moment_n),
          add(all.second_legendre_n, own.second_legendre_n, most.second_legendre_n)};
}

// A friction lower than what was seen to hold was not there all along: if it is there now, it has just
// fallen. Its contact is then the likeliest friction's, as far as less friction still holds that.
void FrictionFilter::doubt_likeliest(const Reading& reading, double sign, double open_n) noexcept {
  const contact::ShearMoments &seen = reading.moments, &noise = reading.moments_sigma;
  const std::size_t likeliest = grid_.likeliest();
  const auto expected = foundations_.shear_moments(likeliest);
  const bool clean = std::max(noise.slip_moment_n, noise.second_legendre_n) < options_.clean_share * open_n;
  const double gain = clean ? 1 : options_.noisy_residual_gain;
  MomentResiduals& mean = grasp_.moment_residuals;
  mean.slip_moment_n += gain * (seen.slip_moment_n - sign * expected.slip_moment_n - mean.slip_moment_n);
  mean.second_legendre_n +=
      gain * (seen.second_legendre_n - sign * expected.second_legendre_n - mean.second_legendre_n);
  const double most_n = std::max(std::fabs(mean.slip_moment_n), std::fabs(mean.second_legendre_n));
  if (!(most_n > (clean ? options_.doubt_share : options_.noisy_doubt_share) * open_n)) return;
  grasp_.doubt_frames = std::max(grasp_.doubt_frames, clean ? options_.doubt_frames : 1);
  if (clean) foundations_.weaken(likeliest, [this](std::size_t j) { return grid_.refuted(j); });
}

// Bayes: half of each friction's squared residual is taken from its log weight, unless nothing explains the
// frame.
bool FrictionFilter::take_evidence(const PerFriction& residuals, bool confirms_monotonic,
                                   double share) noexcept {
  const double likeliest = residuals[grid_.likeliest()];
  const double least =
      *std::min_element(residuals.begin(), residuals.begin() + static_cast<std::ptrdiff_t>(grid_.count()));
  grasp_.surprised = likeliest > options_.surprising_residual;
  grasp_.mean_residual = options_.residual_memory * grasp_.mean_residual +
                         (1 - options_.residual_memory) * std::min(least, options_.max_residual);
  grasp_.cusum.add(0.5 * likeliest, options_.cusum_drift_nats);
  if (least > options_.outlier_residual) {
    if (history_.outlier()) lose_history(HistoryEvent::outlier_run);
    return false;
  }
  if (grasp_.cusum.nats > options_.cusum_threshold_nats) {
    grasp_.cusum = {};
    forget_common();
    grid_.reset();
  }
  if (grasp_.surprised || doubted()) forget_common();
  history_.explained(confirms_monotonic);
  const double half = 0.5 * share;
  for (std::size_t j = 0; j < grid_.count(); ++j) grid_.take(j, half * (residuals[j] - least));
  return true;
}

// Whether memory may answer. `clear`: the frame's shear is far above the noise.
void FrictionFilter::verify(const ContactPatch& patch, bool clear) noexcept {
  const double step_n =
      std::hypot(patch.shear_x_n - grasp_.last_shear_x_n, patch.shear_y_n - grasp_.last_shear_y_n);
  grasp_.last_shear_x_n = patch.shear_x_n;
  grasp_.last_shear_y_n = patch.shear_y_n;
  const bool was_clear = std::exchange(grasp_.last_clear, clear);
  if (clear) {
    grasp_.shear_lost = false;
    ++grasp_.unverified_frames;
    return;
  }
  const double limit_n = grid_.friction(grid_.likeliest()) * patch.normal_n;
  if (was_clear && patch.shear_n < step_n && step_n > options_.max_lost_step * limit_n)
    grasp_.shear_lost = true;
}

// Friction does not change by so much between two frames, but noise may turn one peak into another: what was
// something else a frame ago is doubted until it has stood for a while.
void FrictionFilter::doubt_jump() noexcept {
  const double likeliest = grid_.friction(grid_.likeliest());
  if (grasp_.likeliest > 0 && std::fabs(std::log(likeliest / grasp_.likeliest)) > options_.jump_log)
    grasp_.doubt_frames = options_.doubt_frames;
  grasp_.likeliest = likeliest;
}

// Coulomb: friction is the |Q|/P of a slide.
void FrictionFilter::weigh_slide(const TractionRatioFilter::Slide& slide) noexcept {
  for (std::size_t j = 0; j < grid_.count(); ++j) {
    const double off = std::log(grid_.friction(j) / slide.load) / slide.sigma;
    grid_.take(j, options_.frame_share * 0.5 * std::min(off * off, options_.max_slide_residual));
  }
}

}  // namespace slipd
