#include "drivers/sim/effects/texture.hpp"

#include <cmath>
#include <numbers>

#include "core/numeric/random.hpp"

namespace slipd::sim {

Texture::Texture(const TextureSettings& settings, std::uint64_t seed) noexcept
    : amplitude_m_(settings.rms_m * std::sqrt(2.0 / kWaves)) {
  const RandomStream draws(seed);
  std::uint64_t i = 0;
  for (Wave& wave : waves_) {
    const double direction_rad = draws.uniform(i++, 0, 2 * std::numbers::pi);
    const double length_m =
        settings.shortest_m * std::pow(settings.longest_m / settings.shortest_m, draws.uniform(i++));
    const double k = 2 * std::numbers::pi / length_m;
    wave = {k * std::cos(direction_rad), k * std::sin(direction_rad),
            draws.uniform(i++, 0, 2 * std::numbers::pi)};
  }
}

double Texture::height_m(double x_m, double y_m) const noexcept {
  double sum = 0;
  for (const Wave& wave : waves_) sum += std::cos(wave.kx * x_m + wave.ky * y_m + wave.phase_rad);
  return amplitude_m_ * sum;
}

}  // namespace slipd::sim
