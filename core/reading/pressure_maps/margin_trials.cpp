#include "core/reading/pressure_maps/margin_trials.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"
#include "core/numeric/posterior_sums.hpp"

namespace slipd {

double ShearSquares::unexplained_share() const noexcept {
  if (!(excess_pa2 > kClearSigmas * noise_pa2)) return 0;
  return std::sqrt(excess_pa2 / std::max(explained_pa2, excess_pa2));
}

void MarginTrials::weigh_friction(double measured, double square_pa2, MarginTrial& trial) const noexcept {
  const FrictionPrior::Weighed weighed = prior_.weigh(measured, square_pa2 / trial.noise_pa2);
  trial.friction = weighed.mu;
  trial.nats = weighed.nats;
}

std::optional<std::size_t> MarginTrials::best() const noexcept {
  std::optional<std::size_t> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double against = trials_[i].misfit + trials_[i].nats;
    if (!(trials_[i].friction > 0 && against < least)) continue;
    best = i;
    least = against;
  }
  return best;
}

std::optional<std::size_t> MarginTrials::closest() const noexcept {
  std::optional<std::size_t> closest;
  for (std::size_t i = 0; i < kSteps; ++i) {
    if (trials_[i].friction > 0 && (!closest || trials_[i].residual_pa2 < trials_[*closest].residual_pa2))
      closest = i;
  }
  return closest;
}

void MarginTrials::weigh(Reading& out) const noexcept {
  double least = std::numeric_limits<double>::infinity();
  for (const MarginTrial& trial : trials_) {
    if (trial.friction > 0) least = std::min(least, trial.misfit + trial.nats);
  }
  PosteriorSums margins, frictions;
  for (const MarginTrial& trial : trials_) {
    if (trial.friction <= 0) continue;
    const double weight = std::exp(least - trial.misfit - trial.nats);
    margins.add(weight, trial.gamma);
    frictions.add(weight, trial.friction);
  }
  if (!(margins.weight() > 0)) return;
  out.in_model = true;
  out.gamma = margins.mean();
  out.sigma = std::sqrt(margins.variance());
  out.friction = frictions.mean();
  out.friction_sigma = std::sqrt(frictions.variance());
}

void MarginTrials::give_profile(Reading& out) const noexcept {
  constexpr double kNone = 50;  // nats against a margin that would need a friction below 0
  double least = std::numeric_limits<double>::infinity();
  for (const MarginTrial& trial : trials_) {
    if (trial.friction > 0) least = std::min(least, trial.misfit);
  }
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    const MarginTrial& trial = trials_[kStepsOfProfile * j + kStepsOfProfile / 2];
    out.profile.misfit[j] = trial.friction > 0 ? std::min(kNone, trial.misfit - least) : kNone;
  }
  out.profile.known = true;
}

void conclude(const ContactPatch& patch, const MarginTrial& best, double unexplained_share,
              Reading& out) noexcept {
  const double by_model = norm(kUnevenShare, kUnexplainedSigma * unexplained_share);
  out.common_sigma = norm(by_model, out.sigma * std::sqrt(best.map_share));
  out.sigma = norm(out.sigma, by_model);
  const double rest = 1 - out.gamma;
  out.friction_sigma = out.sigma < kKnownFrictionShare * rest
                           ? norm(out.friction_sigma, out.friction * by_model / rest)
                           : std::numeric_limits<double>::infinity();
  out.center_x_m = patch.center_x_m;
  out.center_y_m = patch.center_y_m;
  out.radius_m = patch.radius_m;
}

}  // namespace slipd
