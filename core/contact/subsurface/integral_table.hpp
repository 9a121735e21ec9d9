// Fills an IntegralTable. For files whose loops exist once for each instruction set: always inlined.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/contact/subsurface/subsurface_point.hpp"

namespace slipd::contact::subsurface {

// Hermite's cubics through the integrals and their slopes dI_a/dm = -2/((A + m^2) sqrt((A + m^2)(B + m^2))).
[[gnu::always_inline]] inline void fill_integrals(double aa, double bb, double shorter, double first,
                                                  double per_step, double* to) noexcept {
  constexpr int kNodes = IntegralTable::kIntervals + 1;
  constexpr double kLast = 1 - 1e-6;
  double ia[kNodes], ib[kNodes], da[kNodes], db[kNodes];
#pragma omp simd
  for (int i = 0; i < kNodes; ++i) {
    const double place = std::min(first + i / per_step, kLast), rest = 1 / (1 - place);
    const double m = shorter * place * rest, al = aa + m * m, bl = bb + m * m;
    const AxisIntegrals at = axis_integrals(aa, bb, m * m);
    const double slope = -2 * shorter * rest * rest / (per_step * std::sqrt(al * bl));
    ia[i] = at.a;
    ib[i] = at.b;
    da[i] = slope / al;
    db[i] = slope / bl;
  }
  for (int i = 0; i < IntegralTable::kIntervals; ++i, to += IntegralTable::kPerInterval) {
    const double rise_a = ia[i + 1] - ia[i], rise_b = ib[i + 1] - ib[i];
    to[0] = ia[i];
    to[1] = da[i];
    to[2] = 3 * rise_a - 2 * da[i] - da[i + 1];
    to[3] = da[i] + da[i + 1] - 2 * rise_a;
    to[4] = ib[i];
    to[5] = db[i];
    to[6] = 3 * rise_b - 2 * db[i] - db[i + 1];
    to[7] = db[i] + db[i + 1] - 2 * rise_b;
  }
}

}  // namespace slipd::contact::subsurface
