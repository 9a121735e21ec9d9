// What a fit leaves over that noise does not explain, whatever it fits: noise averages out over a part of the
// contact, another shape or another history of the load does not. Estimate thread; nothing allocates.
#pragma once

#include <array>
#include <cstddef>

namespace slipd {

// Residuals of pressure, part by part of the disc.
class ResidualParts {
 public:
  // radius: of the contact, in the unit of u and v.
  explicit ResidualParts(double radius) noexcept : half_(0.5 * radius * radius) {}

  // A sample at (u, v) from the contact's centre.
  void add(double u, double v, double off_pa) noexcept {
    Part& part = parts_[(u > 0 ? 1U : 0U) + (v > 0 ? 2U : 0U) + (u * u > v * v ? 4U : 0U) +
                        (u * u + v * v > half_ ? 8U : 0U)];
    part.off_pa += off_pa;
    part.samples += 1;
  }

  // Root mean square over all samples of what stands clearly above their noise, Pa; 0: nothing does.
  // unknowns: that were fitted to the pressure.
  double beyond_noise_pa(double noise_pa, double unknowns) const noexcept;

 private:
  struct Part {
    double off_pa = 0, samples = 0;
  };
  const double half_;
  std::array<Part, 16> parts_;
};

// Residuals of shear, ring by ring about the contact's centre.
class ResidualRings {
 public:
  // distance: from the centre, over the contact's radius in that direction. held_pa: the shear there if all
  // slipped.
  void add(double distance, double off_pa, double held_pa) noexcept {
    const auto which = static_cast<std::size_t>(distance * kRings);
    Ring& ring = rings_[which < kRings ? which : kRings - 1];
    ring.off_pa += off_pa;
    ring.held_pa += held_pa;
    ring.samples += 1;
  }

  // Mean of the rings' squared residuals, over the noise of their samples and a skin that is uneven by this
  // share.
  double misfit(double noise_pa, double uneven_share) const noexcept;

 private:
  static constexpr std::size_t kRings = 12;
  struct Ring {
    double off_pa = 0, held_pa = 0, samples = 0;
  };
  std::array<Ring, kRings> rings_;
};

}  // namespace slipd
