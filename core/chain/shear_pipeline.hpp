// What the pipelines of all sensors that measure shear have in common: force and torque as one pull, the path
// of the load, a source of margins, the bound and the advice.
#pragma once

#include <memory>

#include "core/chain/contact_pipeline.hpp"
#include "core/load/equivalent_pull.hpp"
#include "core/load/load_path.hpp"
#include "core/margin/margin_bound.hpp"
#include "core/margin/margin_source.hpp"
#include "core/margin/surface_load.hpp"

namespace slipd {

class ShearPipeline : public ContactPipeline {
 public:
  bool carries_torque() const noexcept override { return torque_ != TorqueEffect::none; }
  void forget() noexcept override;
  void lose_sight() noexcept override;

 protected:
  // common_sigma: of SurfaceForces.
  ShearPipeline(const ChainSetup& setup, double common_sigma);

  // Once for each frame.
  EquivalentPullResult pull_of(const ContactPatch& patch) noexcept;
  // Once for each frame.
  LoadStep follow(const Load& load) noexcept { return path_.follow(load); }
  MarginSource& margin() const noexcept { return *margin_; }
  // The last of a frame: the lower bound by the load that acts, and what a gripper could do. internal_n: what
  // taxels carry against each other, N.
  void conclude(const SurfaceLoad& load, double internal_n, const EquivalentPullResult& pull,
                MarginDecision& decision, Estimate& out) const noexcept;

 private:
  const std::unique_ptr<EquivalentPull> equivalent_pull_;
  const std::unique_ptr<MarginSource> margin_;
  const MarginBound bound_;
  const double target_margin_;
  LoadPath path_;
  TorqueEffect torque_ = TorqueEffect::none;  // of the last frame
};

}  // namespace slipd
