#include "core/estimate/friction_grid.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

constexpr double kSceneSpread = 0.15;  // how softly the expected range ends, in log mu
constexpr double kForgetAfterSeconds =
    5;                              // a grasp's friction may change: evidence fades towards the scene's
constexpr double kOneFrame = 0.5;   // of a frame's evidence: neighbouring frames share the skin's unevenness
constexpr double kHighest = 2;      // deviations by which a load may miss the highest one
constexpr double kPlateau = 0.015;  // relative: Q/P this even while P changes is sliding
constexpr double kPlateauChange = 0.06;  // relative change of P that makes a plateau one

}  // namespace

FrictionGrid::FrictionGrid(Range expected) {
  for (std::size_t j = 0; j < kCount; ++j) {
    friction_[j] = kLow * std::pow(kHigh / kLow, static_cast<double>(j) / (kCount - 1));
    const double beyond =
        std::max({0.0, std::log(friction_[j] / expected.high), std::log(expected.low / friction_[j])}) /
        kSceneSpread;
    prior_[j] = -0.5 * beyond * beyond;
  }
  reset();
}

void FrictionGrid::reset() noexcept {
  weight_ = prior_;
  highest_load_ = 0;
  slide_normal_n_ = slide_load_ = 0;
  last_ns_ = 0;
}

void FrictionGrid::update(std::int64_t time_ns, double normal_n, double load, double load_sigma,
                          const MarginProfile* profile) noexcept {
  const double passed_s = last_ns_ > 0 ? static_cast<double>(time_ns - last_ns_) * 1e-9 : 0;
  last_ns_ = time_ns;
  const double keep = std::exp(-std::max(0.0, passed_s) / kForgetAfterSeconds);
  const double sigma = std::max(load_sigma, 0.005 * load);
  const bool highest = load > highest_load_ - kHighest * load_sigma;
  highest_load_ = std::max(highest_load_, load - load_sigma);
  for (std::size_t j = 0; j < kCount; ++j) {
    weight_[j] = prior_[j] + keep * (weight_[j] - prior_[j]);
    const double over = (load - friction_[j]) / sigma;  // more is carried than this friction could hold
    if (over > 0) weight_[j] -= kOneFrame * 0.5 * over * over;
    if (profile != nullptr && profile->known && highest) {
      weight_[j] -= kOneFrame * profile->at(1 - load / friction_[j]);
    }
  }
  weigh_sliding(normal_n, load, load_sigma);
  normalise();
}

// Coulomb: an object that slides keeps Q/P while P changes. (While both grow from nothing a stuck contact
// does so too.)
void FrictionGrid::weigh_sliding(double normal_n, double load, double load_sigma) noexcept {
  const bool even = std::fabs(load - slide_load_) < kPlateau * slide_load_ + 2 * load_sigma;
  if (!even || slide_load_ == 0 || normal_n > slide_normal_n_) {
    slide_load_ = load;
    slide_normal_n_ = normal_n;
    return;
  }
  if (normal_n > (1 - kPlateauChange) * slide_normal_n_ || load < 0.9 * highest_load_) return;
  for (std::size_t j = 0; j < kCount; ++j) {
    const double off = std::log(friction_[j] / load) / (3 * kPlateau);
    weight_[j] -= kOneFrame * 0.5 * std::min(off * off, 25.0);
  }
}

void FrictionGrid::normalise() noexcept {
  const double most = *std::max_element(weight_.begin(), weight_.end());
  for (double& w : weight_) w -= most;
}

FrictionGrid::Belief FrictionGrid::belief() const noexcept {
  double sum = 0, mean = 0, square = 0;
  for (std::size_t j = 0; j < kCount; ++j) {
    const double w = std::exp(weight_[j]);
    sum += w;
    mean += w * friction_[j];
    square += w * friction_[j] * friction_[j];
  }
  mean /= sum;
  return {mean, std::sqrt(std::max(0.0, square / sum - mean * mean) + 4e-4 * mean * mean)};
}

FrictionGrid::Belief FrictionGrid::margin(double load, double load_sigma) const noexcept {
  double sum = 0, mean = 0, square = 0;
  for (std::size_t j = 0; j < kCount; ++j) {
    const double w = std::exp(weight_[j]), gamma = std::clamp(1 - load / friction_[j], 0.0, 1.0);
    sum += w;
    mean += w * gamma;
    square += w * gamma * gamma;
  }
  mean /= sum;
  const double mobilised = 1 - mean, step = std::log(kHigh / kLow) / (kCount - 1) * mobilised;
  return {mean, std::sqrt(std::max(0.0, square / sum - mean * mean) + step * step / 12 +
                          std::pow(load_sigma * mobilised / std::max(load, 1e-9), 2))};
}

}  // namespace slipd
