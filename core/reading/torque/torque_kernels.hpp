// The loops over taxels of FrictionPlateau and TorqueMomentRatio. They exist once for each instruction set
// (torque_kernels.cpp, built several times), chosen when first used. Estimate thread; nothing here
// allocates.
#pragma once

#include <cstddef>
#include <span>

#include "core/patch/disc_kernels.hpp"
#include "core/simd/taxel_runs.hpp"

namespace slipd {

// Which taxels count, and what noise makes of their ratio |q|/p.
struct RatioTest {
  float least_pa = 0;       // of the pressure p
  float rectified_pa2 = 0;  // what noise adds to |q|^2
};

struct RatioSums {
  std::size_t stored = 0;  // values in each list, with gaps of pressure 0; a multiple of the lanes
  std::size_t taxels = 0;  // that count
  double normal_pa = 0;    // sum of their pressures
};

// A taxel's ratio has the variance noise_pa2/p^2 + gain, and is of the plateau within sqrt(within) of its
// standard deviations about `ratio`.
struct PlateauTest {
  float ratio = 0, noise_pa2 = 0, gain = 0, within = 0;
};

// Over the taxels of a plateau; weights are 1/variance, `off` is a taxel's ratio less that of the test.
struct PlateauSums {
  std::size_t taxels = 0;
  double weight = 0, off = 0;       // sum of weights; weighted sum of `off`
  double width = 0;                 // sum of 1/sigma
  double normal_pa = 0;             // sum of pressures
  double p = 0, pp = 0, p_off = 0;  // weighted sums
};

// Power of the shear in a rigid motion, and the most that friction 1 could have: sums of w, w s and w s^2, s
// = r^2/a^2, for w = q.v, p|v| and |v|^2, Pa and 1.
struct TorqueSums {
  double work[3] = {}, limit[3] = {}, speeds[3] = {};
};

// A rigid motion: speed along the contact's direction, and spin times its radius.
struct TorqueMotion {
  float along = 0, spin = 0;
};

// Single precision within a few blocks, double across them.
struct TorqueKernels {
  using Runs = std::span<const TaxelRun>;
  const char* name;
  // Pressure and ratio of the taxels of every `stride`-th run, Pa and 1, one list each; a list has room for
  // the runs' taxels and kMaxLanes more a run.
  RatioSums (*ratios)(const TaxelView&, Runs, std::size_t stride, const RatioTest&, float* pressure_pa,
                      float* ratio) noexcept;
  // Sum of the pressures whose ratio is below a limit.
  double (*below)(const float* pressure_pa, const float* ratio, std::size_t stored, float limit) noexcept;
  // The first two sums of the plateau, and its number of taxels; the others are 0.
  PlateauSums (*near)(const float* pressure_pa, const float* ratio, std::size_t stored,
                      const PlateauTest&) noexcept;
  // All of them.
  PlateauSums (*plateau)(const float* pressure_pa, const float* ratio, std::size_t stored,
                         const PlateauTest&) noexcept;
  TorqueSums (*turning)(const TaxelView&, Runs, const ContactPose&, const TorqueMotion&) noexcept;
  static const TorqueKernels baseline, avx2, avx512;  // chosen by best_kernels
};

}  // namespace slipd
