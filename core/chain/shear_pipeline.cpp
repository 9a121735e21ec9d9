#include "core/chain/shear_pipeline.hpp"

#include "core/advice/alert.hpp"
#include "core/chain/chain_parts.hpp"

namespace slipd {

ShearPipeline::ShearPipeline(const ChainSetup& setup, double common_sigma)
    : equivalent_pull_(make_equivalent_pull(setup.layout)),
      margin_(make_margin_source(setup, common_sigma)),
      bound_(known_friction(setup).range),
      target_margin_(setup.alerts.target_margin) {}

EquivalentPullResult ShearPipeline::pull_of(const ContactPatch& patch) noexcept {
  const EquivalentPullResult pull = equivalent_pull_->of(patch, torque_);
  torque_ = pull.torque_effect;
  return pull;
}

void ShearPipeline::conclude(const SurfaceLoad& load, double internal_n, const EquivalentPullResult& pull,
                             MarginDecision& decision, Estimate& out) const noexcept {
  bound_.apply(load, internal_n, decision, out);
  advise(out, pull.pull_sigma_n, target_margin_);
}

void ShearPipeline::forget() noexcept {
  margin_->forget();
  path_.forget();
  torque_ = TorqueEffect::none;
}

void ShearPipeline::lose_sight() noexcept {
  forget();
  margin_->lose_sight();
}

}  // namespace slipd
