#include "core/friction/friction_filter.hpp"

namespace slipd {
namespace {

double square(double x) noexcept {
  return x * x;
}

}  // namespace

FrictionFilter::FrictionFilter(const FrictionPrior& prior, std::size_t points,
                               const FrictionFilterOptions& options)
    : options_(options), grid_(prior, points, options.grid), history_(options.history) {}

void FrictionFilter::reset_evidence() noexcept {
  grid_.reset();
  history_.contact_lost();
  evidence_ = {};
  frame_ = {};
}

void FrictionFilter::forget_common() noexcept {
  evidence_.discount = {};
  evidence_.of_margins.known = evidence_.of_moments.known = 0;
}

void FrictionFilter::lose_history(HistoryEvent why) noexcept {
  history_.lose(why);
  grid_.reset();
  forget_common();
}

void FrictionFilter::bound_below(const MeanSigma& load, double frames) noexcept {
  for (std::size_t j = 0; j < grid_.count(); ++j) {
    const double over = (load.mean - grid_.friction(j)) / load.sigma;
    if (over > 0) grid_.take(j, frames * 0.5 * over * over);
  }
}

void FrictionFilter::part_errors(const ContactPatch& patch) noexcept {
  const double limit_n = grid_.friction(grid_.likeliest()) * patch.normal_n;
  const double moved = std::hypot((patch.normal_n - evidence_.normal_n) / patch.normal_n,
                                  (patch.shear_n - evidence_.shear_n) / limit_n);
  const double kept = std::exp(-moved / options_.parting_share);
  evidence_.of_margins.known *= kept;
  evidence_.of_moments.known *= kept;
  evidence_.normal_n = patch.normal_n;
  evidence_.shear_n = patch.shear_n;
}

// Friction's relative error is Gamma's over 1 - Gamma. The likeliest friction's Gamma: by the frame's own,
// noise that lowers Gamma would weigh more than noise that raises it.
double FrictionFilter::share_of_margin(double load, const Reading& reading) noexcept {
  if (reading.profile.known || !(reading.common_sigma > 0)) return 1;
  const double utilisation =
      std::clamp(load / grid_.friction(grid_.likeliest()), options_.min_mobilised, 1.0);
  const double all = square(reading.sigma / utilisation), own = square(reading.common_sigma / utilisation),
               usual = evidence_.of_margins.usual(reading.common_sigma, options_.common_gain) / utilisation;
  return evidence_.of_margins.add(square(usual), std::max(all - own, options_.min_noise_share * all));
}

double FrictionFilter::margin_residual(std::size_t friction, double load, const Reading& reading,
                                       const MeanSigma& offset) const noexcept {
  const double utilisation = load / grid_.friction(friction);
  if (reading.profile.known)
    return options_.frame_share * evidence_.discount.share() * 2 *
           reading.profile.at(1 - utilisation - offset.mean);
  const double step = options_.grid_share * grid_.step();
  return square(reading.gamma + offset.mean - 1 + utilisation) /
         (square(reading.sigma) + square(offset.sigma) + square(step * utilisation));
}

bool FrictionFilter::take_evidence(const PerFriction& residuals, bool confirms_monotonic,
                                   double share) noexcept {
  const double likeliest = residuals[grid_.likeliest()];
  const double least =
      *std::min_element(residuals.begin(), residuals.begin() + static_cast<std::ptrdiff_t>(grid_.count()));
  frame_.surprised = likeliest > options_.surprising_residual;
  evidence_.mean_residual = options_.residual_memory * evidence_.mean_residual +
                            (1 - options_.residual_memory) * std::min(least, options_.max_residual);
  evidence_.cusum.add(0.5 * likeliest, options_.cusum_drift_nats);
  if (least > options_.outlier_residual) {
    if (history_.outlier()) lose_history(HistoryEvent::outlier_run);
    return false;
  }
  if (evidence_.cusum.nats > options_.cusum_threshold_nats) {
    evidence_.cusum = {};
    forget_common();
    grid_.reset();
  }
  if (frame_.surprised || doubted()) forget_common();
  history_.explained(confirms_monotonic);
  const double half = 0.5 * share;
  for (std::size_t j = 0; j < grid_.count(); ++j) grid_.take(j, half * (residuals[j] - least));
  return true;
}

}  // namespace slipd
