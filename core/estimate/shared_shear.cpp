#include "core/estimate/shared_shear.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace slipd {
namespace {

using Misfits = std::array<double, MarginProfile::kSteps>;

// Taxels without a pressure; N^2.
constexpr double kNoForce = 1e-12;
// What a taxel carries of a pull that begins, at least; of the mean.
constexpr double kLeastUsual = 0.05;

double square(double x) noexcept {
  return x * x;
}

}  // namespace

SharedShear::SharedShear(const TaxelLayout& layout, const SharedShearOptions& options)
    : options_(options), taxels_(layout.size()), area_m2_(layout.area_m2()) {
  if (taxels_ < kLeastTaxels || taxels_ > kMostTaxels)
    throw std::invalid_argument("shared shear: 6 to 64 taxels");
}

const MarginProfile& SharedShear::update(const ContactPatch& patch) noexcept {
  profile_.known = false;
  const double normal_n = read_normal(patch);
  if (!(normal_n > 0)) return profile_;
  if (state_.field.frames == 0 || normal_n > (1 + options_.normal_rise) * state_.least_normal_n) state_ = {};
  state_.least_normal_n = state_.field.frames == 0 ? normal_n : std::min(state_.least_normal_n, normal_n);

  const double noise_n = area_m2_ * patch.noise_shear_pa;
  const double sigma_n = noise_n * std::sqrt(static_cast<double>(taxels_));
  const Pull pull = read_pull(patch, noise_n);
  const double share = pull.size_n / normal_n;
  if (!state_.pulled &&
      (state_.field.frames == 0 || pull.size_n < options_.pulled * normal_n + 3 * sigma_n)) {
    learn_field(patch, normal_n);
    return profile_;
  }
  state_.pulled = true;
  for (std::size_t i = 0; i < taxels_; ++i) {
    pressed_[i] = normal_n_[i] / normal_n;
    pulled_[i] = (pull_x_n_[i] * pull.x_n + pull_y_n_[i] * pull.y_n) / square(pull.size_n);
  }
  if (share < options_.least_pull) {
    if (state_.highest == 0) learn_begin(pull.size_n);
    return profile_;
  }
  state_.highest = std::max(state_.highest, share);
  if (pull.size_n < options_.pull_sigmas * sigma_n || share < options_.fallen * state_.highest)
    return profile_;
  weigh(std::max(share, patch.shear_n / patch.normal_n), share, pull.size_n, noise_n);
  return profile_;
}

double SharedShear::read_normal(const ContactPatch& patch) noexcept {
  double sum_n = 0;
  for (std::size_t i = 0; i < taxels_; ++i) {
    normal_n_[i] = std::max(0.0, area_m2_ * static_cast<double>(patch.taxels.normal_pa[i]));
    sum_n += normal_n_[i];
  }
  return sum_n;
}

// Shear of pressing goes with each taxel's pressure.
SharedShear::Pull SharedShear::read_pull(const ContactPatch& patch, double noise_n) noexcept {
  const Field& field = state_.field;
  Pull pull;
  for (std::size_t i = 0; i < taxels_; ++i) {
    const double usual = normal_n_[i] / (field.squares[i] + field.frames * square(noise_n) + kNoForce);
    pull_x_n_[i] = area_m2_ * static_cast<double>(patch.taxels.shear_x_pa[i]) - field.x[i] * usual;
    pull_y_n_[i] = area_m2_ * static_cast<double>(patch.taxels.shear_y_pa[i]) - field.y[i] * usual;
    pull.x_n += pull_x_n_[i];
    pull.y_n += pull_y_n_[i];
  }
  pull.size_n = std::hypot(pull.x_n, pull.y_n);
  return pull;
}

void SharedShear::learn_field(const ContactPatch& patch, double normal_n) noexcept {
  Field& field = state_.field;
  if (normal_n < (1 - options_.normal_fall) * field.normal_n) field = {};
  if (field.frames == 0) field.normal_n = normal_n;
  ++field.frames;
  for (std::size_t i = 0; i < taxels_; ++i) {
    field.x[i] += area_m2_ * static_cast<double>(patch.taxels.shear_x_pa[i]) * normal_n_[i];
    field.y[i] += area_m2_ * static_cast<double>(patch.taxels.shear_y_pa[i]) * normal_n_[i];
    field.squares[i] += square(normal_n_[i]);
  }
}

void SharedShear::learn_begin(double pull_n) noexcept {
  ++state_.begun_frames;
  state_.begun_n += pull_n;
  for (std::size_t i = 0; i < taxels_; ++i) state_.begun[i] += pull_n * pulled_[i];
}

// The share of a pull that each taxel carries, if the pull has used up the share `used`, 0 … 1, of what
// friction holds: the least of its friction and of what all that stick carry.
void SharedShear::share_out(double used, PerTaxel& carried) const noexcept {
  double rest = 1, shift = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < taxels_; ++k) {
    const double limit = pressed_[order_[k]] / used, even = rest / static_cast<double>(taxels_ - k);
    if (limit >= even) {
      shift = even;
      break;
    }
    rest -= limit;
  }
  for (std::size_t i = 0; i < taxels_; ++i) carried[i] = std::min(shift, pressed_[i] / used);
}

// How far the pattern has gone since the pull began: mean square, in units of the mean. The pattern of the
// beginning is weighed by its noise against an even one.
double SharedShear::square_way(double noise_n, double pull_n) const noexcept {
  const auto n = static_cast<double>(taxels_);
  const double prior = square(options_.stiffness_sigma);
  const double noise = square(n * noise_n * state_.begun_frames / state_.begun_n);
  PerTaxel usual;
  double sum = 0;
  for (std::size_t i = 0; i < taxels_; ++i) {
    const double begun = n * state_.begun[i] / state_.begun_n;
    usual[i] = std::max(kLeastUsual, (begun * prior + noise) / (prior + noise));
    sum += usual[i];
  }
  double squares = 0;
  for (std::size_t i = 0; i < taxels_; ++i) squares += square(n * (pulled_[i] - usual[i] / sum));
  const double by_noise = noise * square(prior / (prior + noise)) + square(n * noise_n / pull_n);
  return std::max(0.0, squares / n - by_noise);
}

// `load`: |Q|/P; `pull`: of that, what came upon the hold.
void SharedShear::weigh(double load, double pull, double pull_n, double noise_n) noexcept {
  const auto n = static_cast<double>(taxels_);
  double uneven = 0;
  for (std::size_t i = 0; i < taxels_; ++i) {
    order_[i] = static_cast<std::uint8_t>(i);
    uneven += square(n * pressed_[i] - 1) / n;
  }
  std::sort(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(taxels_),
            [this](std::uint8_t a, std::uint8_t b) { return pressed_[a] < pressed_[b]; });
  const bool begin_seen = state_.begun_n > 0;
  const double gone = begin_seen ? std::sqrt(square_way(noise_n, pull_n)) : 0;
  const double way_variance = square(options_.way_sigma) + square(options_.way_sigma_share) * uneven;
  const double share_variance = square(noise_n / pull_n) + square(options_.uneven_mean / n);

  Misfits alone{}, under_layer{};
  PerTaxel carried;
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) {
    const double friction = load / (1 - MarginProfile::gamma_of(j));
    share_out(pull / (friction - load + pull), carried);
    double way = 0;
    for (std::size_t i = 0; i < taxels_; ++i) {
      alone[j] += 0.5 * square(pulled_[i] - carried[i]) /
                  (share_variance + square(options_.uneven_share * carried[i]));
      way += square(n * carried[i] - 1) / n;
    }
    way = options_.spread_share * std::sqrt(way);
    under_layer[j] = 0.5 * square(gone - way) / (square(options_.spread_sigma * way) + way_variance);
  }
  const bool stand_alone = 2 * *std::min_element(alone.begin(), alone.end()) < options_.most_misfit * n;
  const Misfits& misfits = stand_alone ? alone : under_layer;
  const double least = *std::min_element(misfits.begin(), misfits.end());
  for (std::size_t j = 0; j < MarginProfile::kSteps; ++j) profile_.misfit[j] = misfits[j] - least;
  profile_.known = stand_alone || begin_seen;
}

}  // namespace slipd
