// Pipelines of sensors on a curved skin, whose frames have a shape: a method reads each frame, friction over
// time does the rest.
#pragma once

#include <memory>
#include <optional>

#include "core/chain/contact_pipeline.hpp"
#include "core/load/equivalent_pull.hpp"
#include "core/load/load_path.hpp"
#include "core/margin/margin_bound.hpp"
#include "core/margin/margin_source.hpp"
#include "core/margin/surface_load.hpp"
#include "core/reading/torque/torque_reading.hpp"

namespace slipd {

class ShapedPipeline : public ContactPipeline {
 public:
  Method method() const noexcept override { return method_->name(); }
  std::vector<std::string_view> stages() const override {
    return {"equivalent_pull", to_string(method_->name()), forces_->name(), margin_->name()};
  }
  void estimate(const Frame& frame, const ContactPatch& patch, const SlidingVerdict& previous,
                MarginDecision& decision, Estimate& out) noexcept override;
  bool carries_torque() const noexcept override { return torque_ != Turning::none; }
  void forget() noexcept override;
  void lose_sight() noexcept override;

 protected:
  ShapedPipeline(const ChainSetup& setup, std::unique_ptr<SlipMethod> method);

  // What the frame shows by itself; none where it has no shape. pulled: with the equivalent pull.
  virtual std::optional<Reading> read(const Frame& frame, const ContactPatch& patch,
                                      const ContactPatch& pulled,
                                      const EquivalentPullResult& pull) noexcept = 0;
  // Friction as far as it is known, > 0.
  double friction() const noexcept { return margin_->friction(); }
  // Of a frame whose shear is that of a pull.
  Reading read_pull(const Frame& frame, const ContactPatch& patch) noexcept;

 private:
  std::unique_ptr<EquivalentPull> equivalent_pull_;
  std::unique_ptr<SlipMethod> method_;
  LoadPath path_;
  std::unique_ptr<SurfaceForces> forces_;
  std::unique_ptr<MarginSource> margin_;
  const MarginBound bound_;
  const double target_margin_;
  Turning torque_ = Turning::none;  // of the last frame
};

// More than kFewTaxels taxels.
class ArrayPipeline final : public ShapedPipeline {
 public:
  ArrayPipeline(const ChainSetup& setup, std::unique_ptr<SlipMethod> method);
  std::vector<std::string_view> stages() const override;
  void forget() noexcept override;
  void lose_sight() noexcept override;

 protected:
  std::optional<Reading> read(const Frame& frame, const ContactPatch& patch, const ContactPatch& pulled,
                              const EquivalentPullResult& pull) noexcept override;

 private:
  std::unique_ptr<TorqueReading> torque_reading_;
};

// Few taxels: read as a whole, and without a shape under torque.
class FewTaxelsPipeline final : public ShapedPipeline {
 public:
  // Floor of a margin's sigma; Gamma, 0.005 … 0.05.
  static constexpr double kLeastSigma = 0.03;

  FewTaxelsPipeline(const ChainSetup& setup, std::unique_ptr<SlipMethod> method);
  double least_sigma() const noexcept override { return kLeastSigma; }

 protected:
  std::optional<Reading> read(const Frame& frame, const ContactPatch& patch, const ContactPatch& pulled,
                              const EquivalentPullResult& pull) noexcept override;
};

}  // namespace slipd
