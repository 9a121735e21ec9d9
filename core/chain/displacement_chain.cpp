#include "core/chain/displacement_chain.hpp"

namespace slipd {
namespace {

constexpr double kMetresPerMm = 1e-3, kSecondsPerNs = 1e-9;

// A slide that ended with the contact is still told.
State state_of(const GelState& gel) noexcept {
  if (!gel.displacement_mm) return State::out_of_model;
  if (slides(gel.sliding)) return State::no_shear;
  if (!gel.contact) return State::learning;
  return *gel.contact ? State::no_shear : State::no_contact;
}

}  // namespace

void DisplacementChain::set_releasing(bool releasing) noexcept {
  releasing_ = releasing;
  gel_.set_releasing(releasing);
}

void DisplacementChain::follow_sliding(Estimate& out) noexcept {
  if (out.sliding != last_sliding_) sliding_since_ns_ = out.time_ns;
  last_sliding_ = out.sliding;
  if (out.sliding) out.sliding_for_s = static_cast<double>(out.time_ns - sliding_since_ns_) * kSecondsPerNs;
}

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
  follow_sliding(out);
  alert_.judge(out);
  if (releasing_) {
    out.alert = Alert::unknown;  // nobody watches
    out.alert_cause = AlertCause::none;
  }
  return out;
}

}  // namespace slipd
