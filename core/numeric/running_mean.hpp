// Running means over frames: two speeds, which all of them share.
#pragma once

#include <cmath>

namespace slipd {

// Gain, frame by frame, of a mean that follows what changes within a load; 0.05 … 0.5. Too small: it lags
// behind a contact that grows or a load that turns. Too large: noise of single frames decides.
inline constexpr double kQuickGain = 0.2;

// The same of a mean that judges a grasp; 0.01 … 0.3. Too small: gross slip, and a model that no longer fits,
// are seen late. Too large: they are seen in noise.
inline constexpr double kSlowGain = 0.1;

// Standard deviation of a running mean of independent values with this gain, over that of one of them.
inline double sigma_of_mean(double gain) noexcept {
  return std::sqrt(gain / (2 - gain));
}

}  // namespace slipd
