// The contact's pressure and shear as two averaged domes (Fit), fitted to samples: the heights that fit best,
// and the sums that normal equations are made of (docs/methods.md §23). The loops exist once for each
// instruction set (dome_products.cpp, built several times). Estimate thread; nothing allocates.
#pragma once

#include <array>
#include <cstddef>

#include "core/simd/taxel_runs.hpp"

namespace slipd {

// A dome averaged over each sample and its derivatives, see contact::DomeAverage.
struct DomePointers {
  const double *value = nullptr, *d_x = nullptr, *d_u = nullptr, *d_v = nullptr;
};

// Samples: pressure p, shear q along the pull, Pa; the contact's dome o and that of where it sticks i, m.
struct DomeTask {
  DomePointers contact, stick;
  const double *normal_pa = nullptr, *shear_pa = nullptr;
  std::size_t count = 0;
  // Radius of i over that of o.
  double stick_share = 0;
};

// Least squares of p = pressure o and q = shear (o - i), Pa/m. Not finite where no sample is in the contact.
struct DomeHeights {
  double pressure = 0, shear = 0;
};

// Sums over samples of the products of these with each other, the lower half row by row, with r the
// residual, model less sample, Pa:
struct DomeProducts {
  // o by u, v and its radius; o; r of p.
  enum Pressure { pressure_u, pressure_v, pressure_radius, pressure_value, pressure_rest, kPressure };
  std::array<double, kPressure*(kPressure + 1) / 2> pressure{};
  // o - i by u, v and the radius of o, with which that of i grows; o - i; i by its radius; r of q.
  enum Shear { shear_u, shear_v, shear_radius, shear_value, shear_stick, shear_rest, kShear };
  std::array<double, kShear*(kShear + 1) / 2> shear{};
};

struct DomeProductKernels {
  DomeHeights (*heights)(const DomeTask&) noexcept;
  void (*products)(const DomeTask&, const DomeHeights&, DomeProducts&) noexcept;
  static const DomeProductKernels baseline, avx2, avx512;  // chosen by best_kernels
};

}  // namespace slipd
