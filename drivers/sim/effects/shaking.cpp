#include "drivers/sim/effects/shaking.hpp"

#include <cmath>
#include <numbers>

#include "core/numeric/random.hpp"

namespace slipd::sim {

Shaking::Shaking(const ShakingSettings& settings, std::uint64_t seed) noexcept : share_(settings.share) {
  std::uint64_t direction = 0;
  for (auto& waves : waves_) {
    const RandomStream draws = RandomStream(seed).stream(direction++);
    std::uint64_t i = 0;
    for (Wave& wave : waves) {
      wave.hz = draws.uniform(i++, settings.lowest_hz, settings.highest_hz);
      wave.phase_rad = draws.uniform(i++, 0, 2 * std::numbers::pi);
    }
  }
}

double Shaking::value(std::size_t direction, double time_s) const noexcept {
  double sum = 0;
  for (const Wave& wave : waves_[direction])
    sum += std::sin(2 * std::numbers::pi * wave.hz * time_s + wave.phase_rad);
  return share_ * sum * std::sqrt(2.0 / kWaves);
}

}  // namespace slipd::sim
