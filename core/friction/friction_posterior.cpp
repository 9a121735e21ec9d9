#include "core/friction/friction_posterior.hpp"

#include <algorithm>
#include <cmath>

#include "core/numeric/norm.hpp"
#include "core/numeric/running_mean.hpp"

namespace slipd {
namespace {

double square(double x) noexcept {
  return x * x;
}

// Student's t with five degrees of freedom (Lange, Little and Taylor 1989 use four): a frame ten standard
// deviations away counts as much as one that is four away does under a Gaussian.
constexpr double kDegrees = 5;
struct OfResidual {
  double likelihood;
  double weight;  // what such a frame counts for in a mean: 1 without a residual
};
OfResidual of_residual(double squared) noexcept {
  const double per = 1 / (kDegrees + squared), tail = kDegrees * per;
  return {tail * tail * tail, squared > 1 ? (kDegrees + 1) * per : 1};
}

// Nats beyond which nothing is left of a weight.
constexpr double kNothingLeft = 40;

// Nats beyond which a load that is held leaves nothing of a friction. A load of noisy forces may contradict
// all frictions by more than kNothingLeft: the highest is left then. e^-400 of a weight is no denormal.
constexpr double kRefuted = 400;

double most_prior(const FrictionGrid& grid) noexcept {
  double most = 0;
  for (std::size_t j = 0; j < grid.count(); ++j) most = std::max(most, grid.prior(j));
  return most;
}

}  // namespace

FrictionPosterior::FrictionPosterior(const FrictionPrior& prior, std::size_t count,
                                     const FrictionPosteriorOptions& options)
    : options_(options), grid_(prior, count, options.grid), most_prior_(most_prior(grid_)) {}

void FrictionPosterior::reset() noexcept {
  grid_.reset();
  errors_ = {};
  has_changed_ = {};
  frame_ = {};
  changed_ = held_ = {};
  for (std::size_t j = 0; j < grid_.count(); ++j) same_[j] = grid_.prior(j);
}

void FrictionPosterior::begin(double seconds) noexcept {
  frame_ = {};
  for (std::size_t j = 0; j < grid_.count(); ++j) {
    same_[j] = grid_.weight(j);
    changed_[j] = 0;
  }
  may_have_changed(-std::expm1(-options_.falls_per_s * seconds), options_.rises_per_s / options_.falls_per_s);
}

void FrictionPosterior::may_have_changed(double probability, double rises) noexcept {
  const std::size_t likeliest = grid_.likeliest();
  change(probability, [&](std::size_t j) { return (j > likeliest ? rises : 1) * grid_.prior(j); });
}

void FrictionPosterior::may_have_fallen_to(const MeanSigma& load, double probability) noexcept {
  if (!(load.mean > 0)) return;
  const double step = grid_.step();
  const double at = std::log(load.mean / grid_.friction(0)) / step;
  const double width = norm(load.sigma / (load.mean * step), 0.5);  // a point stands for what is near
  PerFriction near{};
  double sum = 0;
  for (std::size_t j = 0; j < grid_.count(); ++j) {
    const double off = (static_cast<double>(j) - at) / width, nats = 0.5 * off * off;
    if (nats > kNothingLeft) continue;
    near[j] = std::exp(-nats);
    sum += near[j];
  }
  if (!(sum > 0)) return;
  const double per = 1 / (sum * most_prior_);
  change(probability, [&](std::size_t j) { return near[j] * grid_.prior(j) * per; });
}

// to: how likely each friction is, if it has changed.
template <class To>
void FrictionPosterior::change(double probability, To to) noexcept {
  for (std::size_t j = 0; j < grid_.count(); ++j) {
    same_[j] *= 1 - probability;
    changed_[j] += probability * (to(j) - changed_[j]);
  }
}

void FrictionPosterior::bound_below(const MeanSigma& held) noexcept {
  const double to_edge = std::exp(0.5 * grid_.step());  // a point stands for what lies about it
  const double per_sigma = 1 / held.sigma;
  for (std::size_t j = 0; j < grid_.count(); ++j) {
    const double over = (held.mean - to_edge * grid_.friction(j)) * per_sigma;
    if (!(over > 0)) break;  // nor any higher one
    const double nats = std::min(kRefuted, 0.5 * over * over);
    changed_[j] *= nats < kRefuted ? std::exp(-nats) : 0;
    if (!(nats > held_[j])) continue;
    same_[j] *= std::exp(held_[j] - nats);
    held_[j] = nats;
  }
}

// Kalman's filter of the common error, for each friction: all have the same gain.
template <bool kWeighed>
void FrictionPosterior::take(Evidence by, std::span<const double> residual, double common,
                             double noise) noexcept {
  CommonError& error = errors_[static_cast<std::size_t>(by)];
  // A frame's own would be larger or smaller with its noise, and so would what is learnt from it.
  const double usual = error.usual > 0 ? error.usual : common;
  error.usual = usual + kQuickGain * (common - usual);
  common = usual;
  noise = std::max(noise, options_.least_noise_share * common);
  const double open = error.variance * common * common, all = open + noise * noise;
  const double gain = common > 0 ? open / (all * common) : 0, per_variance = 1 / all;
  const std::size_t likeliest = grid_.likeliest(), count = grid_.count();
  const double of_likeliest = error.mean[likeliest], before = common * of_likeliest;
  const double surprise = square(residual[likeliest] - before) * per_variance;
  const auto take = [&](double& weight, double residual_now, double mean) {
    const double off = residual_now - common * mean;
    const OfResidual of = of_residual(off * off * per_variance);
    if constexpr (kWeighed) weight *= of.likelihood;
    return mean + gain * of.weight * off;
  };
#pragma omp simd
  for (std::size_t j = 0; j < count; ++j) {
    error.if_changed[j] = take(changed_[j], residual[j], of_likeliest);
    error.mean[j] = take(same_[j], residual[j], error.mean[j]);
  }
  if constexpr (kWeighed) frame_.surprise = std::max(frame_.surprise, surprise);
  error.variance *= 1 - of_residual(surprise).weight * open * per_variance;
  error.weighed = true;
}

void FrictionPosterior::weigh(Evidence by, std::span<const double> residual, double common,
                              double noise) noexcept {
  take<true>(by, residual, common, noise);
}

void FrictionPosterior::follow(Evidence by, std::span<const double> residual, double common,
                               double noise) noexcept {
  take<false>(by, residual, common, noise);
}

bool FrictionPosterior::conclude() noexcept {
  const std::size_t count = grid_.count(), likeliest = grid_.likeliest();
  bool any = false;
  for (std::size_t j = 0; j < count; ++j) {
    has_changed_[j] = j != likeliest && changed_[j] > same_[j];
    any |= has_changed_[j];
    if (has_changed_[j]) held_[j] = 0;
    same_[j] += changed_[j];
  }
  for (CommonError& error : errors_) {
    const bool used = error.usual > 0;
    for (std::size_t j = 0; j < count && any && used; ++j)
      if (has_changed_[j]) error.mean[j] = error.weighed ? error.if_changed[j] : error.mean[likeliest];
    error.weighed = false;
  }
  grid_.assign(same_);
  return any;
}

void FrictionPosterior::decorrelate(double moved) noexcept {
  const double kept = std::exp(-moved / options_.decorrelating_share);
  for (CommonError& error : errors_) {
    if (!(error.usual > 0)) continue;
    error.variance = 1 - kept * kept * (1 - error.variance);
    for (std::size_t j = 0; j < grid_.count(); ++j) error.mean[j] *= kept;
  }
}

}  // namespace slipd
