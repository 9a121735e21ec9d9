// Sums over taxels: what a frame's estimate spends its time on. The loops exist once for each instruction set
// (disc_kernels.cpp, built several times with the flags in CMakeLists.txt); which is used is chosen when a
// PatchFinder is first made, long after main began. Estimate thread; nothing here allocates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/simd/taxel_runs.hpp"

namespace slipd {

// One frame's channels beside the taxels' places, each with at least kLanes values (zeros where there are
// fewer taxels).
struct TaxelView {
  static constexpr std::size_t kLanes = kMaxLanes;
  const float *normal_pa = nullptr, *shear_x_pa = nullptr, *shear_y_pa = nullptr, *x_m = nullptr,
              *y_m = nullptr;
  std::size_t size = 0;
};

struct NoiseSums {
  double squares = 0;     // of pressures below zero
  std::size_t below = 0;  // how many
  float peak = 0;         // the greatest pressure, 0 if none is above
  float least = 0;        // the least pressure, infinite if none is below infinity
};

// A taxel that senses less than this nearer to the centre than that.
struct DeadTaxelTest {
  float below_pa = 0, within_m2 = 0;
};

// Of pressure p at places relative to a centre.
struct PlaceSums {
  double p = 0, px = 0, py = 0, prr = 0;
  std::size_t dead_taxels = 0;
};

// Of pressure p and shear (x, y) in a disc; moments are about a centre.
struct ForceSums {
  double p = 0, x = 0, y = 0;
  double moment = 0;                   // of the shear about the centre: r_x y - r_y x
  double rr = 0;                       // squared distances from the centre, alone
  float peak = 0;                      // of p, at least 0
  float x_extreme = 0, y_extreme = 0;  // the greatest |shear| along x, along y
};

// Powers of s = r^2/a^2, alone and weighted by pressure p and by the shear along a direction q. Then how p
// lies about the centre: p s by each coordinate, p (x^2 - y^2)/a^2 and p x y/a^2.
struct MomentSums {
  double p = 0, q = 0, ps = 0, qs = 0, qss = 0, s = 0, s2 = 0, s3 = 0, s4 = 0, pss = 0, psx = 0, psy = 0,
         px2y2 = 0, pxy = 0;
};

// About a centre, with shear along (direction_x, direction_y).
struct ContactPose {
  float x_m = 0, y_m = 0, direction_x = 1, direction_y = 0, radius_m = 1;
};

// One ring's: pressures, shear along the direction, number of taxels.
struct RingSums {
  double p = 0, q = 0, taxels = 0, unused = 0;
};

// Single precision within a few blocks, double across them: relative to the sum of magnitudes within 1e-6 of
// exact.
struct DiscKernels {
  using Runs = std::span<const TaxelRun>;
  const char* name;
  NoiseSums (*noise)(const TaxelView&) noexcept;
  PlaceSums (*place)(const TaxelView&,
                     float least_pa) noexcept;  // of all taxels with at least this, about the origin
  PlaceSums (*weigh)(const TaxelView&, Runs, float x_m, float y_m, const DeadTaxelTest&) noexcept;
  ForceSums (*force)(const TaxelView&, Runs, float x_m, float y_m) noexcept;  // about this centre
  double (*shear_squares)(const TaxelView&, Runs,
                          const ContactPose&) noexcept;  // of the shear along the direction
  MomentSums (*moments)(const TaxelView&, Runs, const ContactPose&) noexcept;
  // Adds to `count` rings of equal width, of which the last also takes what lies beyond.
  void (*rings)(const TaxelView&, Runs, const ContactPose&, std::size_t count, RingSums* rings) noexcept;
  // Adds `count` values, and the same times `lever`, to two lists.
  void (*add_row)(const float* values, std::size_t count, float lever, float* sums, float* moments) noexcept;
  static const DiscKernels baseline, avx2, avx512;  // chosen by best_kernels
};

}  // namespace slipd
