// The contact summed over rings of equal width in s = r/a: what is left of a frame once place, size and
// direction are taken out. Standard frame of the registered estimator (docs/theory.md §8), and the test
// whether a load has only risen.
#pragma once

#include <array>
#include <cstddef>

#include "core/frame/frame.hpp"
#include "core/patch/patch.hpp"

namespace slipd {

struct Rings {
  static constexpr std::size_t kCount = 16;
  std::array<double, kCount> normal_n{}, shear_n{};  // shear signed along the resultant
  std::array<double, kCount> taxels{};
};

// By the taxels' centres; the last ring also takes what lies beyond s = 1 within the patch's disc.
Rings sum_rings(const ContactPatch& patch, const TaxelLayout& layout) noexcept;

// The share of a disc's force within each ring (docs/theory.md §8.2): D_x of radius k (in units of a, 0 < k
// <= 1) over ring [s0, s1).
double disc_share(double k, double s0, double s1) noexcept;

// How far the rings are from a load that only rose to `gamma` at `friction`: mean square of (measured -
// expected) shear, each ring in units of its own noise and of what the model and the taxels' size leave open.
// About 1 or less in the family; regrip, unloading and reversal give tens to thousands.
double monotonic_misfit(const Rings& rings, const ContactPatch& patch, const TaxelLayout& layout,
                        double gamma, double friction) noexcept;

}  // namespace slipd
