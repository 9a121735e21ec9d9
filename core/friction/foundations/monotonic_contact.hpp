// What a load that has only risen makes of a contact (docs/theory.md §7). Looked up in a table, as it is
// asked for each friction in each frame. Estimate thread; nothing allocates or throws.
#pragma once

namespace slipd {

struct MonotonicContact {
  // Q (5/3 - 5/2 <u>), over mu P; 0 … 2/3.
  double slip_moment = 0;
  // What the margin falls by for each unit of the ratio of second moments that it is read from.
  double gamma_per_moment_ratio = 0;
};

// utilisation: Q/(mu P); beyond 0 … 1 the nearer end. The slip moment is within 1e-5 of its closed form, the
// other within 0.005.
MonotonicContact monotonic_contact(double utilisation) noexcept;

}  // namespace slipd
