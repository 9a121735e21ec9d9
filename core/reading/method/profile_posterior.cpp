#include "core/reading/method/profile_posterior.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numeric/posterior_sums.hpp"

namespace slipd {

void weigh_profile(const ProfileSums& sums, double share, const FrictionPrior& prior, Reading& out) noexcept {
  constexpr double kLeastTraction = 1e-6;  // of Q/P: its logarithm stays finite
  auto& profile = out.profile;
  std::array<double, MarginProfile::kSteps> friction, nats;
  double least = std::numeric_limits<double>::infinity(), least_nats = least;
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    const double squares = sums.squares[j], product = sums.products[j];
    const double t = std::max(kLeastTraction, product / squares);
    friction[j] = t / (1 - MarginProfile::gamma_of(j));
    profile.misfit[j] = share * 0.5 * (t * t * squares - 2 * t * product);
    nats[j] = profile.misfit[j] + prior.nats_against(friction[j]);
    least = std::min(least, profile.misfit[j]);
    least_nats = std::min(least_nats, nats[j]);
  }
  for (double& value : profile.misfit) value -= least;
  profile.known = true;
  PosteriorSums margins, frictions;
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    const double w = std::exp(least_nats - nats[j]);
    margins.add(w, MarginProfile::gamma_of(j));
    frictions.add(w, friction[j]);
  }
  constexpr double kStep = 1.0 / MarginProfile::kSteps;
  const double utilisation = std::max(1 - margins.mean(), kStep / 2);
  out.gamma = margins.mean();
  out.sigma = std::sqrt(margins.variance() + variance_of_step(kStep));
  out.friction = frictions.mean();
  out.friction_sigma = std::sqrt(frictions.variance() + variance_of_step(out.friction / utilisation * kStep));
}

}  // namespace slipd
