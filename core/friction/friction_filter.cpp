#include "core/friction/friction_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"
#include "core/numeric/running_mean.hpp"

namespace slipd {
namespace {

double square(double x) noexcept {
  return x * x;
}

}  // namespace

FrictionFilter::FrictionFilter(const FrictionPrior& prior, std::size_t points,
                               const FrictionFilterOptions& options)
    : options_(options),
      posterior_(prior, points, options.posterior),
      history_(options.history),
      traction_ratio_(options.traction_ratio) {}

void FrictionFilter::reset_evidence() noexcept {
  posterior_.reset();
  history_.contact_lost();
  traction_ratio_.reset();
  mean_residual_ = 1;
}

void FrictionFilter::lose_history(HistoryEvent why) noexcept {
  history_.lose(why);
  posterior_.reset();
}

void FrictionFilter::begin_frame(const FrictionFrame& frame) noexcept {
  traction_ratio_.update(frame.patch);
  const LoadStep& step = frame.step;
  const Load &now = step.now, before = step.before();
  const double friction = likeliest();
  posterior_.decorrelate(norm((now.normal_n - before.normal_n) / now.normal_n,
                              (now.pull_n - before.pull_n) / (friction * now.normal_n)));
  posterior_.begin(step.seconds());
  if (!step.previous || now.under_torque || before.under_torque) return;
  const MeanSigma load = now.ratio(), earlier = before.ratio();
  const double drop = earlier.mean - load.mean, sigma = norm(load.sigma, earlier.sigma);
  if (drop > 0) weigh_drop(load, {drop / friction, sigma / friction}, step.seconds());
}

void FrictionFilter::bound_by_held() noexcept {
  MeanSigma held = traction_ratio_.held();
  held.mean = std::min(held.mean, traction_ratio_.now().mean);  // the mean lags behind a load that falls
  posterior_.bound_below(held);
}

// Most loads are held, and noise is all that falls. Others are let go at speeds of an exponential
// distribution, which noise adds to: what is likeliest of both together is Huber's function of the fall
// (1964). A fall of friction may be of any size.
void FrictionFilter::weigh_drop(const MeanSigma& load, const MeanSigma& drop, double seconds) noexcept {
  if (!(seconds > 0 && drop.sigma > 0)) return;  // of a sensor whose noise is not known a fall says nothing
  const double fallen = drop.mean, noise = drop.sigma;
  const double usual = options_.unload_per_s * seconds, steep = noise / usual;
  const double nats =
      fallen < noise * steep ? 0.5 * square(fallen / noise) : fallen / usual - 0.5 * square(steep);
  const double let_go =
      options_.unload_share * std::exp(-nats) / (usual + std::sqrt(std::numbers::pi / 2) * noise);
  const double held = (1 - options_.unload_share) * std::exp(-0.5 * square(fallen / noise)) /
                      (std::sqrt(2 * std::numbers::pi) * noise);
  const double fell = -std::expm1(-options_.posterior.falls_per_s * seconds);
  posterior_.may_have_fallen_to(load, fell / (fell + let_go + held));
}

// A margin between two points of the grid is off by up to half a step, in each frame alike.
void FrictionFilter::weigh_margin(std::span<const double> residuals, const Reading& reading,
                                  double offset_sigma, double utilisation) noexcept {
  const double between = std::sqrt(variance_of_step(grid().step() * utilisation));
  const double common = norm(norm(reading.common_sigma, offset_sigma), between);
  const double noise = std::sqrt(std::max(0.0, square(reading.sigma) - square(reading.common_sigma)));
  posterior_.weigh(Evidence::margin, residuals, common, noise);
}

// The signed root of twice the misfit is a residual in units of the frame's noise (Barndorff-Nielsen 1986).
void FrictionFilter::weigh_profile(const MarginProfile& profile, double load) noexcept {
  const auto best = std::min_element(profile.misfit.begin(), profile.misfit.end()) - profile.misfit.begin();
  const double best_gamma = MarginProfile::gamma_of(static_cast<std::size_t>(best));
  PerFriction residuals;  // the first grid().count() of them
  for (std::size_t j = 0; j < grid().count(); ++j) {
    const double gamma = 1 - load / grid().friction(j);
    residuals[j] = std::copysign(std::sqrt(2 * std::max(0.0, profile.at(gamma))), best_gamma - gamma);
  }
  posterior_.weigh(Evidence::margin, residuals, options_.profile_common_share, 1);
}

// One wild frame counts as one that is off by twice what is clear.
bool FrictionFilter::explain(double least_squared, bool confirms_monotonic) noexcept {
  const bool outlier = least_squared > square(kClearSigmas);
  mean_residual_ += kSlowGain * (std::min(least_squared, square(2 * kClearSigmas)) - mean_residual_);
  if (!outlier) {
    history_.explained(confirms_monotonic);
  } else if (history_.outlier()) {
    lose_history(HistoryEvent::outlier_run);
  }
  return !outlier;
}

}  // namespace slipd
