#include "core/friction/by_shape.hpp"

#include <utility>

#include "core/reading/moments/moments.hpp"

namespace slipd {
namespace {

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

FrictionByShape::FrictionByShape(const FrictionPrior& prior, const FrictionFilterOptions& options)
    : FrictionFilter(prior, options.foundations, options),
      forces_(options.forces),
      foundations_(grid_.frictions().first(std::min(grid_.count(), options.foundations))) {}

void FrictionByShape::reset() noexcept {
  reset_evidence();
  forces_.reset();
  foundations_.clear();
  grasp_ = {};
}

void FrictionByShape::lose_sight() noexcept {
  reset();
  history_.lose(HistoryEvent::unseen);
}

void FrictionByShape::update(const FrictionFrame& frame) noexcept {
  const ContactPatch& patch = frame.patch;
  const Reading* const reading = frame.reading;
  const MeanSigma ratio{patch.shear_n / patch.normal_n, patch.shear_sigma_n / patch.normal_n};
  frame_ = {.traction_ratio = ratio};
  bound_below({ratio.mean, std::max(ratio.sigma, options_.traction_ratio.held_floor_frame * ratio.mean)}, 1);
  const bool turning = reading != nullptr && reading->under_torque;
  if (!turning) follow(patch);
  grasp_.turning = turning;
  grasp_.doubt_frames = std::max(0, grasp_.doubt_frames - 1);
  const bool clear = reading != nullptr && patch.shear_n > options_.min_shear_sigmas * patch.shear_sigma_n;
  verify(frame, clear);
  if (!clear || turning) grasp_.slip_moment.known = false;
  if (clear && (turning ? weigh_torque(patch, *reading) : weigh_frame(frame))) grasp_.unverified_frames = 0;
  // Nothing that sticks again shows friction, but it may show that friction is not as it was learnt.
  if (clear && turning && reading->load_fallen &&
      reading->friction < options_.held_ratio * grid_.friction(grid_.likeliest()))
    grasp_.unverified_frames = 0;
  grid_.normalise();
  doubt_jump();
}

void FrictionByShape::follow(const ContactPatch& patch) noexcept {
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

void FrictionByShape::lose_history(HistoryEvent why) noexcept {
  FrictionFilter::lose_history(why);
  foundations_.assume_monotonic(forces_.normal_n(), forces_.shear_n());
}

// Gamma is read from S/Q = 5/3 - rho, so that a slip moment that is larger than a monotonic load's by dS
// reads as a margin that is smaller by dGamma/drho dS/Q.
MeanSigma FrictionByShape::offset_of(std::size_t friction, double load, double normal_n) const noexcept {
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

bool FrictionByShape::looks_monotonic(double normal_n, double load) noexcept {
  const std::size_t j = grid_.likeliest();
  const double mu = grid_.friction(j), limit_n = mu * normal_n;
  const double monotonic_n = limit_n * monotonic_slip_moment(1 - load / mu);
  grasp_.margin_offset = offset_of(j, load, normal_n);
  return std::fabs(std::fabs(foundations_.shear_moments(j).slip_moment_n) - monotonic_n) <
         options_.monotonic_share_of_shear * load * normal_n + options_.monotonic_share_of_limit * limit_n;
}

bool FrictionByShape::weigh_frame(const FrictionFrame& frame) noexcept {
  const ContactPatch& patch = frame.patch;
  const Reading& reading = *frame.reading;
  const double load = patch.shear_n / patch.normal_n;
  history_.classify(looks_monotonic(patch.normal_n, load));
  grasp_.other_history |= !is_monotonic(history());
  const contact::ShearMoments& common = reading.moments_common_sigma;
  contact::ShearMoments& locked_in = grasp_.locked_in_sigma;
  if (is_monotonic(history())) locked_in = {};
  locked_in = {std::max(locked_in.slip_moment_n, common.slip_moment_n),
               std::max(locked_in.second_legendre_n, common.second_legendre_n)};
  if (is_known(history())) {
    detect_fall(frame);
  } else {
    grasp_.slip_moment.known = false;
  }
  PerFriction residuals;  // the first grid_.count() of them
  if (is_monotonic(history()) && reading.in_model) {
    compare_margin(patch, reading, residuals);
    evidence_.discount.add(reading.sigma / options_.alike_sigma);
    part_errors(patch);
    return take_evidence(residuals, reading.sigma < options_.confirming_sigma,
                         share_of_margin(load, reading));
  }
  if (!is_known(history()) || !std::isfinite(reading.moments_sigma.slip_moment_n)) return false;
  compare_moments(patch, reading, residuals);
  part_errors(patch);
  return take_evidence(residuals, false, share_of_moments(patch, reading));
}

// A frame whose field a torque has changed shows friction itself, by taxels that slip, whatever the history.
bool FrictionByShape::weigh_torque(const ContactPatch& patch, const Reading& reading) noexcept {
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
  return take_evidence(residuals, false, evidence_.of_margins.add(square(common), noise));
}

// Of a frame's slip moment, over Q.
double FrictionByShape::share_of_moments(const ContactPatch& patch, const Reading& reading) noexcept {
  const double all = square(with_locked_in(reading).slip_moment_n / patch.shear_n),
               grid = grasp_.locked_in_sigma.slip_moment_n / patch.shear_n,
               usual = evidence_.of_moments.usual(grid, options_.common_gain),
               model = square(options_.model_sigma_share * options_.uneven_share);
  return evidence_.of_moments.add(square(usual) + model,
                                  std::max(all - square(grid), options_.min_noise_share * (all + model)));
}

// Errors of the model and of the taxels' size are the same in two frames, so that the step from one to the
// next is known much better than either: where the slip moment grows by more than the forces' step explains,
// friction has fallen.
void FrictionByShape::detect_fall(const FrictionFrame& frame) noexcept {
  const Reading& reading = *frame.reading;
  const LoadStep& step = frame.step;
  const SlipMoment last = grasp_.slip_moment;
  SlipMoment& now = grasp_.slip_moment;
  if (!std::isfinite(reading.moments_sigma.slip_moment_n)) {
    now.known = false;
    return;
  }
  now = {.known = true,
         .friction = grid_.likeliest(),
         .seen_n = forces_.axis().cosine(frame.patch) * reading.moments.slip_moment_n,
         .expected_n = foundations_.shear_moments(grid_.likeliest()).slip_moment_n,
         .sigma_n = std::sqrt(std::max(0.0, square(reading.moments_sigma.slip_moment_n) -
                                                square(reading.moments_common_sigma.slip_moment_n)))};
  if (!last.known || last.friction != now.friction || !step.previous) return;
  const double step_n = (now.seen_n - last.seen_n) - (now.expected_n - last.expected_n);
  const double along_n = forces_.axis().along_n(step.now);
  const double moved_n =
      std::fabs(along_n - forces_.axis().along_n(*step.previous)) +
      grid_.friction(now.friction) * std::fabs(step.now.normal_n - step.previous->normal_n);
  const double explained_n = options_.fall_sigmas * std::hypot(now.sigma_n, last.sigma_n) +
                             options_.fall_share_of_step * moved_n +
                             options_.fall_share * frame.patch.shear_n;
  if (!(std::copysign(1.0, along_n) * step_n > explained_n)) return;
  forget_common();
  grasp_.fallen = true;
  grid_.open_below(options_.fallen_nats);
  foundations_.weaken(now.friction, [](std::size_t) { return true; });
  grasp_.doubt_frames = std::max(grasp_.doubt_frames, 1);
}

void FrictionByShape::compare_margin(const ContactPatch& patch, const Reading& reading,
                                     PerFriction& residuals) const noexcept {
  const double load = patch.shear_n / patch.normal_n;
  const bool followed = grasp_.other_history || grasp_.margin_offset.mean != 0;
  const std::size_t likeliest = grid_.likeliest();
  for (std::size_t j = 0; j < grid_.count(); ++j) {
    const bool near = j + options_.offset_reach >= likeliest && j <= likeliest + options_.offset_reach;
    residuals[j] = margin_residual(
        j, load, reading, followed && near ? offset_of(j, load, patch.normal_n) : grasp_.margin_offset);
  }
}

void FrictionByShape::compare_moments(const ContactPatch& patch, const Reading& reading,
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
contact::ShearMoments FrictionByShape::with_locked_in(const Reading& reading) const noexcept {
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
void FrictionByShape::doubt_likeliest(const Reading& reading, double sign, double open_n) noexcept {
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

// Whether memory may answer. `clear`: the frame's shear is far above the noise.
void FrictionByShape::verify(const FrictionFrame& frame, bool clear) noexcept {
  const bool was_clear = std::exchange(grasp_.last_clear, clear);
  if (clear) {
    grasp_.shear_lost = false;
    ++grasp_.unverified_frames;
    return;
  }
  const double limit_n = grid_.friction(grid_.likeliest()) * frame.patch.normal_n;
  const double moved_n = frame.step.shear_moved_n();
  if (was_clear && frame.patch.shear_n < moved_n && moved_n > options_.max_lost_step * limit_n)
    grasp_.shear_lost = true;
}

// Friction does not change by so much between two frames, but noise may turn one peak into another: what was
// something else a frame ago is doubted until it has stood for a while.
void FrictionByShape::doubt_jump() noexcept {
  const double likeliest = grid_.friction(grid_.likeliest());
  if (grasp_.likeliest > 0 && std::fabs(std::log(likeliest / grasp_.likeliest)) > options_.jump_log)
    grasp_.doubt_frames = options_.doubt_frames;
  grasp_.likeliest = likeliest;
}

}  // namespace slipd
