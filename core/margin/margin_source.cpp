#include "core/margin/margin_source.hpp"

#include <algorithm>
#include <cmath>

#include "core/frame/significance.hpp"

namespace slipd {

void SingleFrameMargin::estimate(const MarginInput& frame, MarginDecision& decision, Estimate& out) noexcept {
  out.method = Method::friction;
  if (frame.reading == nullptr) return decision.refuse(State::learning);
  const Reading& reading = *frame.reading;
  if (!reading.in_model) return decision.refuse(State::out_of_model);
  out.method = reading.by;
  decision.propose({reading.gamma, reading.sigma});
  if (!std::isfinite(reading.friction_sigma)) return;
  out.friction = reading.friction;
  out.friction_sigma = reading.friction_sigma;
  decision.rely_on(std::max(0.0, reading.friction - kOneSided95 * reading.friction_sigma));
}

}  // namespace slipd
