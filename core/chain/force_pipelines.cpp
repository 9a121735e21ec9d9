#include "core/chain/force_pipelines.hpp"

#include <cmath>

#include "core/chain/chain_parts.hpp"

namespace slipd {
namespace {

// Pressing makes a torque on a flat pad as well, most where the object is held off its middle. A torque that
// is no larger than on real pads is left to gamma_low; with a larger one there is no margin. Of what the
// contact carries, 0.1 … 0.5; quiet grasps of real pillars reach 0.27. Too small: such grasps lose their
// margin. Too large: margins under a torque are too safe.
constexpr double kTorqueOfPressing = 0.3;

}  // namespace

void PressureOnlyPipeline::estimate(const Frame& /*frame*/, const ContactPatch& patch,
                                    const SlidingVerdict& /*previous*/, MarginDecision& /*decision*/,
                                    Estimate& out) noexcept {
  out.normal_n = patch.normal_n;
  if (has_taxels_) publish_place(patch, out);
}

void ForcePipeline::estimate_by_sums(const ContactPatch& patch, const SlidingVerdict& previous,
                                     MarginDecision& decision, Estimate& out) noexcept {
  publish_forces(patch, out);
  const EquivalentPullResult pull = pull_of(patch);
  out.pull_n = pull.pull_n;
  const ContactPatch pulled = with_pull(patch, pull);
  margin().estimate({.measured = patch,
                     .step = follow(load_of(out.time_ns, patch, pulled, false)),
                     .acting = pulled,
                     .previous_sliding = previous},
                    decision, out);
  conclude(measured_load(patch, pulled), 0, pull, decision, out);
}

void OneForcePipeline::estimate(const Frame& /*frame*/, const ContactPatch& patch,
                                const SlidingVerdict& previous, MarginDecision& decision,
                                Estimate& out) noexcept {
  estimate_by_sums(patch, previous, decision, out);
}

void PillarPipeline::estimate(const Frame& /*frame*/, const ContactPatch& patch,
                              const SlidingVerdict& previous, MarginDecision& decision,
                              Estimate& out) noexcept {
  publish_place(patch, out);
  publish_torque(patch, out);
  estimate_by_sums(patch, previous, decision, out);
}

FlatPadPipeline::FlatPadPipeline(const ChainSetup& setup)
    : ForcePipeline(setup),
      usual_friction_(std::sqrt(known_friction(setup).range.low * known_friction(setup).range.high)) {}

void FlatPadPipeline::estimate(const Frame& frame, const ContactPatch& patch, const SlidingVerdict& previous,
                               MarginDecision& decision, Estimate& out) noexcept {
  const FieldCourse& field = previous.field;
  publish_forces(patch, out);
  publish_place(patch, out);
  publish_torque(patch, out);
  ContactPatch unpressed = patch;
  unpressed.torque_nm = field.settled ? patch.torque_nm - field.pressing_lever_m * patch.normal_n : 0;
  const EquivalentPullResult pull = pull_of(unpressed);
  out.pull_n = patch.shear_n;
  if (field.internal_share > kMaxInternalShare) decision.refuse(State::out_of_model);
  margin().estimate({.measured = patch,
                     .step = follow(load_of(out.time_ns, patch, patch, false)),
                     .acting = patch,
                     .shared = shared(frame, patch),
                     .previous_sliding = previous},
                    decision, out);
  refuse_torque(patch, pull.pull_n, decision, out);
  conclude(measured_load(patch, with_pull(patch, pull)), field.internal_share * patch.normal_n, pull,
           decision, out);
}

void FlatPadPipeline::refuse_torque(const ContactPatch& patch, double pull_n, MarginDecision& decision,
                                    const Estimate& out) const noexcept {
  const double carried_n = out.friction.value_or(usual_friction_) * patch.normal_n;
  if (pull_n - patch.shear_n > kTorqueOfPressing * carried_n) decision.refuse(State::out_of_model);
}

bool SharingFlatPadPipeline::serves(const ChainSetup& setup) noexcept {
  const std::size_t taxels = setup.layout.size();
  const bool given_value = setup.friction && setup.friction->is_value();
  return !given_value && taxels >= PadLoadSharing::kLeastTaxels && taxels <= PadLoadSharing::kMostTaxels;
}

void SharingFlatPadPipeline::forget() noexcept {
  FlatPadPipeline::forget();
  sharing_.forget();
}

}  // namespace slipd
