#include "core/chain/displacement_chain.hpp"

namespace slipd {
namespace {

constexpr double kMetresPerMm = 1e-3;

// A slide that ended with the contact is still told.
State state_of(const GelState& gel) noexcept {
  if (!gel.displacement_mm) return State::out_of_model;
  if (slides(gel.sliding)) return State::no_shear;
  if (!gel.contact) return State::learning;
  return *gel.contact ? State::no_shear : State::no_contact;
}

}  // namespace

Estimate DisplacementChain::estimate(const Frame& frame) noexcept {
  const GelState& gel = gel_.update(frame);
  Estimate out;
  out.sequence = frame.sequence;
  out.time_ns = frame.time_ns;
  out.method = Method::displacement;
  out.health = Health::good;
  out.state = state_of(gel);
  if (gel.displacement_mm) out.displacement_m = kMetresPerMm * *gel.displacement_mm;
  out.contact = gel.contact;
  out.slide_evidence = gel.evidence;
  out.sliding = gel.sliding;
  out.sliding_for_s = sliding_time_.update(out.sliding, out.time_ns);
  alert_.judge(out);
  if (gel_.releasing()) {
    out.alert = Alert::unknown;  // nobody watches
    out.alert_cause = AlertCause::none;
  }
  return out;
}

}  // namespace slipd
