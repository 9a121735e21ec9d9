#include "core/reading/fit/residual_sums.hpp"

#include <cmath>

#include "core/frame/significance.hpp"

namespace slipd {

double ResidualParts::beyond_noise_pa(double noise_pa, double unknowns) const noexcept {
  double squares = 0, samples = 0;
  for (const Part& part : parts_) {
    squares += part.samples > 0 ? part.off_pa * part.off_pa / part.samples : 0;
    samples += part.samples;
  }
  const double free = static_cast<double>(parts_.size()) - unknowns, by_noise = noise_pa * noise_pa;
  if (squares < (free + kClearSigmas * std::sqrt(2 * free)) * by_noise) return 0;
  return std::sqrt((squares - free * by_noise) / samples);
}

double ResidualRings::misfit(double noise_pa, double uneven_share) const noexcept {
  double sum = 0;
  int used = 0;
  for (const Ring& ring : rings_) {
    if (ring.samples < 1) continue;
    const double uneven_pa = uneven_share * ring.held_pa;
    sum += ring.off_pa * ring.off_pa / (noise_pa * noise_pa * ring.samples + uneven_pa * uneven_pa);
    ++used;
  }
  return used > 0 ? sum / used : 0;
}

}  // namespace slipd
