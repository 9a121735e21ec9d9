// The contact summed over rings of equal width in s = r/a, which removes position, size and direction from a
// frame. Input of the registered estimator (docs/methods.md §21), and of the test for monotonic loading.
#pragma once

#include <array>
#include <cstddef>

#include "core/frame/frame.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

// Mean square deviation of the rings from a monotonic load, from which on a frame has another history, or is
// of a skin that is no half space; 1.5 … 20, about 1 after a monotonic load. Too small: such skins are
// refused. Too large: a regrip passes.
inline constexpr double kMaxRingMisfit = 4;

struct Rings {
  // Number of rings. Fewer blur the edge of the stick zone; more leave rings with too few taxels.
  static constexpr std::size_t kCount = 16;
  // Normal force of each ring, N.
  std::array<double, kCount> normal_n{};
  // Shear force of each ring along the resultant, N; signed.
  std::array<double, kCount> shear_n{};
  // Taxels in each ring.
  std::array<double, kCount> taxels{};
};

// Assigns each taxel to a ring by its centre. The last ring also has the taxels beyond s = 1 within the
// patch's disc.
Rings sum_rings(const ContactPatch& patch, const TaxelLayout& layout) noexcept;

// The share of a disc's force within each ring (docs/methods.md §21.2): D_x of radius k (in units of a, 0 < k
// <= 1) over ring [s0, s1).
double disc_share(double k, double s0, double s1) noexcept;

// How far the rings are from monotonic loading to `gamma` at `friction`: mean square of (measured - expected)
// shear, each ring in units of its noise and of the expected deviation of model and taxel size. About 1 or
// less for monotonic loading; regrip, unloading and reversal give tens to thousands.
double monotonic_misfit(const Rings& rings, const ContactPatch& patch, const TaxelLayout& layout,
                        double gamma, double friction) noexcept;

}  // namespace slipd
