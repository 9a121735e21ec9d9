// Pipelines of sensors whose margin comes from forces and friction over time: one force, and flat pads, whose
// taxels' shear means nothing by itself.
#pragma once

#include "core/chain/shear_pipeline.hpp"
#include "core/friction/pad_load_sharing.hpp"

namespace slipd {

// Sensors without shear: contact, faults, and slides by the pattern; never a margin.
class PressureOnlyPipeline final : public ContactPipeline {
 public:
  explicit PressureOnlyPipeline(bool has_taxels) noexcept : has_taxels_(has_taxels) {}
  Method method() const noexcept override { return Method::friction; }
  std::optional<State> refused() const noexcept override { return State::no_shear; }
  std::vector<std::string_view> stages() const override { return {}; }
  void estimate(const Frame& frame, const ContactPatch& patch, const SlidingVerdict& previous,
                MarginDecision& decision, Estimate& out) noexcept override;
  void forget() noexcept override {}
  void lose_sight() noexcept override {}

 private:
  const bool has_taxels_;
};

// What force sensors have in common: friction over time alone.
class ForcePipeline : public ShearPipeline {
 public:
  std::vector<std::string_view> stages() const override { return {"equivalent_pull", margin().name()}; }
  Method method() const noexcept override { return Method::friction; }

 protected:
  explicit ForcePipeline(const ChainSetup& setup) : ShearPipeline(setup, 0) {}
  // Force and torque as they are summed over the contact, as one pull.
  void estimate_by_sums(const ContactPatch& patch, const SlidingVerdict& previous, MarginDecision& decision,
                        Estimate& out) noexcept;
};

// One force vector, with or without its torque.
class OneForcePipeline final : public ForcePipeline {
 public:
  explicit OneForcePipeline(const ChainSetup& setup) : ForcePipeline(setup) {}
  void estimate(const Frame& frame, const ContactPatch& patch, const SlidingVerdict& previous,
                MarginDecision& decision, Estimate& out) noexcept override;
};

// Tips of pillars: each carries its own force, and friction shows in what it carries.
class PillarPipeline final : public ForcePipeline {
 public:
  explicit PillarPipeline(const ChainSetup& setup) : ForcePipeline(setup) {}
  void estimate(const Frame& frame, const ContactPatch& patch, const SlidingVerdict& previous,
                MarginDecision& decision, Estimate& out) noexcept override;
};

// Several taxels on a flat skin. Only sums over them count, and of the torque only its change since the
// contact settled: pressing makes a torque as well, and it grows with P.
class FlatPadPipeline : public ForcePipeline {
 public:
  explicit FlatPadPipeline(const ChainSetup& setup);
  void estimate(const Frame& frame, const ContactPatch& patch, const SlidingVerdict& previous,
                MarginDecision& decision, Estimate& out) noexcept override;

 protected:
  // What the taxels show of the margin; null: nothing.
  virtual const MarginProfile* shared(const Frame& /*frame*/, const ContactPatch& /*patch*/) noexcept {
    return nullptr;
  }

 private:
  void refuse_torque(const ContactPatch& patch, double pull_n, MarginDecision& decision,
                     const Estimate& out) const noexcept;

  const double usual_friction_;  // while that of the grasp is not known
};

// The same where friction is not known to a value: taxels that are pressed least slip first.
class SharingFlatPadPipeline final : public FlatPadPipeline {
 public:
  explicit SharingFlatPadPipeline(const ChainSetup& setup) : FlatPadPipeline(setup), sharing_(setup.layout) {}
  // Whether such a pad has a pattern, and needs it.
  static bool serves(const ChainSetup& setup) noexcept;
  std::vector<std::string_view> stages() const override {
    return {"equivalent_pull", "pad_load_sharing", margin().name()};
  }
  void forget() noexcept override;

 protected:
  const MarginProfile* shared(const Frame& frame, const ContactPatch& patch) noexcept override {
    return &sharing_.update(frame, patch);
  }

 private:
  PadLoadSharing sharing_;
};

}  // namespace slipd
