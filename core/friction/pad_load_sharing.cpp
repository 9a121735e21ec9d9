#include "core/friction/pad_load_sharing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/frame/significance.hpp"
#include "core/load/load_path.hpp"
#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

// Taxels without a pressure; N^2.
constexpr double kNoForce = 1e-12;
// What a taxel carries of a pull that begins, at least; of the mean.
constexpr double kLeastUsual = 0.05;

double square(double x) noexcept {
  return x * x;
}

// Misfit of what may be in one of two ways: minus the logarithm of the sum of both likelihoods.
double either(double one, double other) noexcept {
  return std::min(one, other) - std::log1p(std::exp(-std::fabs(one - other)));
}

// Of a pull that has used up the share `used` of what friction holds: what each of all that stick carries of
// it. Those that slip carry their limit/used, less than that. `limits`: n, ascending, of sum 1.
double shift_of(const double* limits, std::size_t n, double used) noexcept {
  double rest = 1;
  for (std::size_t k = 0; k < n; ++k) {
    const double limit = limits[k] / used, even = rest / static_cast<double>(n - k);
    if (limit >= even) return even;
    rest -= limit;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

PadLoadSharing::PadLoadSharing(const TaxelLayout& layout, const PadLoadSharingOptions& options)
    : options_(options), taxels_(layout.size()), area_m2_(layout.area_m2()) {
  if (taxels_ < kLeastTaxels || taxels_ > kMostTaxels)
    throw std::invalid_argument("shared shear: 6 to 64 taxels");
}

const MarginProfile& PadLoadSharing::update(const Frame& frame, const ContactPatch& patch) noexcept {
  frame_ = {};
  const double normal_n = read_normal(frame);
  if (!(normal_n > 0)) return frame_.profile;
  if (state_.field.frames == 0 || normal_n > (1 + kChanged) * state_.least_normal_n) state_ = {};
  state_.least_normal_n = state_.field.frames == 0 ? normal_n : std::min(state_.least_normal_n, normal_n);

  const double noise_n = area_m2_ * patch.noise_shear_pa;
  const double sigma_n = noise_n * std::sqrt(static_cast<double>(taxels_));
  const Pull pull = read_pull(frame, noise_n);
  const double share = pull.size_n / normal_n;
  if (!state_.pulled && (state_.field.frames == 0 || pull.size_n < kPulled * normal_n + 3 * sigma_n)) {
    learn_field(frame, normal_n);
    return frame_.profile;
  }
  state_.pulled = true;
  for (std::size_t i = 0; i < taxels_; ++i) {
    frame_.pressed[i] = frame_.normal_n[i] / normal_n;
    frame_.pulled[i] = (frame_.pull_x_n[i] * pull.x_n + frame_.pull_y_n[i] * pull.y_n) / square(pull.size_n);
  }
  if (share < options_.least_pull) {
    if (state_.highest == 0) learn_begin(pull, share);
    return frame_.profile;
  }
  state_.highest = std::max(state_.highest, share);
  if (pull.size_n < kStandsOutSigmas * sigma_n || share < kFallen * state_.highest) return frame_.profile;
  weigh({.load = std::max(share, patch.shear_n / patch.normal_n), .pull = share, .noise_n = noise_n}, pull);
  return frame_.profile;
}

double PadLoadSharing::read_normal(const Frame& frame) noexcept {
  double sum_n = 0;
  for (std::size_t i = 0; i < taxels_; ++i) {
    frame_.normal_n[i] = std::max(0.0, area_m2_ * static_cast<double>(frame.normal_pa[i]));
    sum_n += frame_.normal_n[i];
  }
  return sum_n;
}

// Shear of pressing goes with each taxel's pressure.
PadLoadSharing::Pull PadLoadSharing::read_pull(const Frame& frame, double noise_n) noexcept {
  const Field& field = state_.field;
  Pull pull;
  for (std::size_t i = 0; i < taxels_; ++i) {
    const double usual = frame_.normal_n[i] / (field.squares[i] + field.frames * square(noise_n) + kNoForce);
    frame_.pull_x_n[i] = area_m2_ * static_cast<double>(frame.shear_x_pa[i]) - field.x[i] * usual;
    frame_.pull_y_n[i] = area_m2_ * static_cast<double>(frame.shear_y_pa[i]) - field.y[i] * usual;
    pull.x_n += frame_.pull_x_n[i];
    pull.y_n += frame_.pull_y_n[i];
  }
  pull.size_n = norm(pull.x_n, pull.y_n);
  return pull;
}

void PadLoadSharing::learn_field(const Frame& frame, double normal_n) noexcept {
  Field& field = state_.field;
  if (normal_n < (1 - kChanged) * field.normal_n) field = {};
  if (field.frames == 0) field.normal_n = normal_n;
  ++field.frames;
  for (std::size_t i = 0; i < taxels_; ++i) {
    field.x[i] += area_m2_ * static_cast<double>(frame.shear_x_pa[i]) * frame_.normal_n[i];
    field.y[i] += area_m2_ * static_cast<double>(frame.shear_y_pa[i]) * frame_.normal_n[i];
    field.squares[i] += square(frame_.normal_n[i]);
  }
}

void PadLoadSharing::learn_begin(const Pull& pull, double share) noexcept {
  ++state_.begun_frames;
  state_.begun_n += pull.size_n;
  state_.begun_x_n += pull.x_n;
  state_.begun_y_n += pull.y_n;
  state_.begun_share += pull.size_n * share;
  for (std::size_t i = 0; i < taxels_; ++i) state_.begun[i] += pull.size_n * frame_.pulled[i];
}

// What friction holds of each taxel, if that goes with its pressure to this power, one half of the taxel
// rougher than the other.
void PadLoadSharing::find_limits(double power, Limits& limits) const noexcept {
  const auto n = static_cast<double>(taxels_);
  double sum = 0;
  for (std::size_t i = 0; i < taxels_; ++i) {
    const double acting = std::pow(n * frame_.pressed[i], power);
    limits[2 * i] = (1 - options_.uneven) * acting;
    limits[2 * i + 1] = (1 + options_.uneven) * acting;
    sum += 2 * acting;
  }
  std::sort(limits.begin(), limits.begin() + static_cast<std::ptrdiff_t>(2 * taxels_));
  for (std::size_t k = 0; k < 2 * taxels_; ++k) limits[k] /= sum;
}

// Root mean square, of the mean, of what the pattern changes from one load to another.
double PadLoadSharing::way_between(const Limits& limits, double used, double used_before) const noexcept {
  const std::size_t n = 2 * taxels_;
  const double now = shift_of(limits.data(), n, used), before = shift_of(limits.data(), n, used_before);
  double squares = 0;
  for (std::size_t k = 0; k < n; ++k)
    squares += square(std::min(now, limits[k] / used) - std::min(before, limits[k] / used_before));
  return std::sqrt(squares * static_cast<double>(n));
}

// The pattern of the beginning is weighed by its noise against an even one.
PadLoadSharing::Way PadLoadSharing::way_of(const Pull& pull, double noise_n) const noexcept {
  const auto n = static_cast<double>(taxels_);
  const double prior = square(options_.way_sigma);
  const double noise = square(n * noise_n * state_.begun_frames / state_.begun_n),
               noise_now = square(n * noise_n / pull.size_n);
  PerTaxel usual;
  double sum = 0;
  for (std::size_t i = 0; i < taxels_; ++i) {
    const double begun = n * state_.begun[i] / state_.begun_n;
    usual[i] = std::max(kLeastUsual, (begun * prior + noise) / (prior + noise));
    sum += usual[i];
  }
  double squares = 0, uneven = 0;
  for (std::size_t i = 0; i < taxels_; ++i) {
    squares += square(n * (frame_.pulled[i] - usual[i] / sum));
    uneven += square(n * frame_.pressed[i] - 1);
  }
  const double begun_n = norm(state_.begun_x_n, state_.begun_y_n) + kNoForce;
  const double turned = (state_.begun_x_n * pull.y_n - state_.begun_y_n * pull.x_n) / (begun_n * pull.size_n);
  const double by_noise = noise * square(prior / (prior + noise)) + noise_now;
  return {.gone = std::max(0.0, squares / n - by_noise),
          .still = square(options_.still_way) + square(options_.still_way_share) * uneven / n +
                   square(options_.uneven * turned) + noise_now / 2};
}

// Of taxels that stand alone each one's shear.
void PadLoadSharing::compare_pattern(const Loads& loads, const Pull& pull, Misfits& alone) const noexcept {
  const auto n = static_cast<double>(taxels_);
  const double variance = square(loads.noise_n / pull.size_n) + square(options_.uneven / n);
  PerTaxel sorted = frame_.pressed;
  std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(taxels_));
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    const double used = loads.used(loads.pull, j), shift = shift_of(sorted.data(), taxels_, used);
    for (std::size_t i = 0; i < taxels_; ++i) {
      const double carried = std::min(shift, frame_.pressed[i] / used);
      alone[j] += 0.5 * square(frame_.pulled[i] - carried) / (variance + square(options_.uneven * carried));
    }
  }
}

void PadLoadSharing::compare_way(const Loads& loads, const Way& way, Misfits& alone,
                                 Misfits& under_layer) const noexcept {
  const auto misfit = [&](double expected, double sigma) {
    return 0.5 * square(0.5 * std::log((way.gone + way.still) / (square(expected) + way.still)) / sigma);
  };
  const double begun = state_.begun_share / state_.begun_n;
  Limits sensed, acting;
  find_limits(1, sensed);
  find_limits(options_.spread_pressure, acting);
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    const double now = loads.used(loads.pull, j), before = loads.used(begun, j);
    alone[j] += misfit(way_between(sensed, now, before), options_.way_sigma);
    under_layer[j] = misfit(options_.spread_shear * way_between(acting, now, before), options_.way_sigma);
  }
}

// Whether taxels stand alone is weighed as well: a layer fits as well as taxels alone at most_misfit.
void PadLoadSharing::weigh(const Loads& loads, const Pull& pull) noexcept {
  const double open = 0.5 * options_.most_misfit * static_cast<double>(taxels_);
  const bool begin_seen = state_.begun_n > 0;
  Misfits alone{}, under_layer{};
  compare_pattern(loads, pull, alone);
  if (begin_seen) compare_way(loads, way_of(pull, loads.noise_n), alone, under_layer);
  frame_.profile.known = begin_seen || *std::min_element(alone.begin(), alone.end()) < open;
  if (!frame_.profile.known) return;
  Misfits& misfits = frame_.profile.misfit;
  misfits = alone;
  if (begin_seen) {
    const double least_layer = *std::min_element(under_layer.begin(), under_layer.end());
    for (std::size_t j = 0; j < MarginProfile::kSteps; ++j)
      misfits[j] = either(alone[j], under_layer[j] - least_layer + open);
  }
  const double least = *std::min_element(misfits.begin(), misfits.end());
  for (double& misfit : misfits) misfit -= least;
}

}  // namespace slipd
