// The margin on the safe side of all that is not known: what holds with 95 % confidence by forces and
// friction. Estimate thread; plain state.
#pragma once

#include "core/contact/scene.hpp"
#include "core/estimate/estimate.hpp"
#include "core/margin/margin_decision.hpp"
#include "core/margin/surface_load.hpp"

namespace slipd {

class MarginBound {
 public:
  // known: friction that was given, else what the scene expects, mu.
  explicit MarginBound(Range known) noexcept : known_(known) {}

  // internal_n: force that taxels carry against each other, N, >= 0, as if it came on top: no more than that
  // is used up of friction. Friction is the least that `decision` relies on, or else the low end of what is
  // known. Bounds the decision, and writes limit_low_n.
  void apply(const SurfaceLoad& load, double internal_n, MarginDecision& decision,
             Estimate& out) const noexcept;

 private:
  const Range known_;
};

}  // namespace slipd
