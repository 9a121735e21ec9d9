#include "core/estimate/carried_load.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {
namespace {

// Without shape the load is followed with its slope (an alpha-beta filter), and anew where it jumps.
constexpr double kLevel = 0.35, kSlope = 0.08, kJump = 4;
constexpr double kMeanGain = 0.1, kMeanSigma = 0.23;  // of its mean, and that's deviation over one frame's
constexpr double kSmoothed = 0.53;  // its deviation over one frame's: sqrt((2a^2 + 2b - 3ab)/(a(4 - 2a - b)))
constexpr double kHighest = 2;      // deviations by which a load may miss the highest one
constexpr double kPlateauChange = 0.06;  // relative change of P that makes a plateau one

}  // namespace

void CarriedLoad::read(const ContactPatch& patch) noexcept {
  const double load = patch.shear_n / patch.normal_n, sigma = patch.shear_sigma_n / patch.normal_n;
  const double expected = now_.mean + change_, off = load - expected;
  mean_ += (now_.sigma == 0 ? 1 : kMeanGain) * (load - mean_);
  if (!shapeless_ || now_.sigma == 0 || std::fabs(off) > kJump * sigma) {
    now_ = {load, sigma};
    change_ = 0;
    return;
  }
  change_ += kSlope * off;
  now_ = {std::max(0.0, expected + kLevel * off), kSmoothed * sigma};
}

CarriedLoad::Held CarriedLoad::held() const noexcept {
  if (!shapeless_) return {{now_.mean, std::max(now_.sigma, 0.01 * now_.mean)}, 1};
  return {{mean_, std::max(kMeanSigma * now_.sigma / kSmoothed, 0.005 * now_.mean)}, kMeanGain};
}

bool CarriedLoad::is_highest(double load, double sigma) const noexcept {
  return load > highest_ - kHighest * sigma;
}

std::optional<double> CarriedLoad::look_for_sliding(double normal_n) noexcept {
  const auto [load, sigma] = now_;
  highest_ = std::max(highest_, load - sigma);
  const bool even = std::fabs(load - slide_load_) < kPlateau * slide_load_ + 2 * sigma;
  if (!even || slide_load_ == 0 || normal_n > slide_normal_n_) {
    slide_load_ = load;
    slide_normal_n_ = normal_n;
    return std::nullopt;
  }
  if (normal_n > (1 - kPlateauChange) * slide_normal_n_ || load < 0.9 * highest_) return std::nullopt;
  return load;
}

}  // namespace slipd
