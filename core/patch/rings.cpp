#include "core/patch/rings.hpp"

#include <algorithm>
#include <cmath>

#include "core/numeric/norm.hpp"
#include "core/simd/instruction_sets.hpp"

namespace slipd {
namespace {

// Expected deviation of a ring's shear from the model, as a fraction of mu p; range 0.02 to 0.2. Real skins
// are no half space. Too small: monotonic loading is refused. Too large: unloading is taken for monotonic.
constexpr double kModelTolerance = 0.06;
// The same because square taxels cut rings, as a fraction of mu p times taxel side over contact radius; range
// 0.2 to 1. Too small: contacts of few taxels are refused. Too large: their unloading is not noticed.
constexpr double kTaxelTolerance = 0.5;

}  // namespace

Rings sum_rings(const ContactPatch& patch, const TaxelLayout& layout) noexcept {
  std::array<RingSums, Rings::kCount> sums{};
  best_kernels<DiscKernels>().rings(patch.taxels, patch.runs, patch.pose(), Rings::kCount, sums.data());
  Rings rings;
  const double area = layout.area_m2();
  for (std::size_t j = 0; j < Rings::kCount; ++j) {
    rings.normal_n[j] = sums[j].p * area;
    rings.shear_n[j] = sums[j].q * area;
    rings.taxels[j] = sums[j].taxels;
  }
  return rings;
}

double disc_share(double k, double s0, double s1) noexcept {
  const auto beyond = [k](double s) {
    const double rest = 1 - s * s / (k * k);
    return rest > 0 ? rest * std::sqrt(rest) : 0.0;
  };
  return beyond(s0) - beyond(s1);
}

double monotonic_misfit(const Rings& rings, const ContactPatch& patch, const TaxelLayout& layout,
                        double gamma, double friction) noexcept {
  const double k = std::max(1e-9, std::cbrt(gamma));
  const double noise_n = norm(patch.noise_shear_pa, friction * patch.noise_normal_pa) * layout.area_m2();
  const double open = kModelTolerance + kTaxelTolerance * layout.side_m() / patch.radius_m;
  double sum = 0;
  int used = 0;
  for (std::size_t j = 0; j < Rings::kCount; ++j) {
    if (rings.taxels[j] < 1) continue;
    const double s0 = static_cast<double>(j) / Rings::kCount, s1 = static_cast<double>(j + 1) / Rings::kCount;
    const double whole = disc_share(1, s0, s1);
    // Expected as a ratio to the pressure that this very ring has, so that its taxels' number cancels.
    const double ratio = friction * (1 - gamma * disc_share(k, s0, s1) / whole);
    const double expected = ratio * rings.normal_n[j];
    const double spread = norm(noise_n * std::sqrt(rings.taxels[j]), open * friction * rings.normal_n[j]);
    if (!(spread > 0)) continue;
    const double off = (rings.shear_n[j] - expected) / spread;
    sum += off * off;
    ++used;
  }
  return used > 0 ? sum / used : 0;
}

}  // namespace slipd
