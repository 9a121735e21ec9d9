// Pipelines of sensors on a curved skin, whose frames have a shape: a method reads each frame, friction over
// time does the rest.
#pragma once

#include <memory>
#include <optional>

#include "core/chain/shear_pipeline.hpp"
#include "core/frame/model_errors.hpp"
#include "core/reading/torque/torque_reading.hpp"

namespace slipd {

class ShapedPipeline : public ShearPipeline {
 public:
  Method method() const noexcept override { return method_->name(); }
  std::vector<std::string_view> stages() const override {
    return {"equivalent_pull", to_string(method_->name()), forces_->name(), margin().name()};
  }
  void estimate(const Frame& frame, const ContactPatch& patch, const SlidingVerdict& previous,
                MarginDecision& decision, Estimate& out) noexcept override;
  void forget() noexcept override;

 protected:
  ShapedPipeline(const ChainSetup& setup, std::unique_ptr<SlipMethod> method);

  // What the frame shows by itself; none where it has no shape. pulled: with the equivalent pull.
  virtual std::optional<Reading> read(const Frame& frame, const ContactPatch& patch,
                                      const ContactPatch& pulled,
                                      const EquivalentPullResult& pull) noexcept = 0;
  // Of a frame whose shear is that of a pull.
  Reading read_pull(const Frame& frame, const ContactPatch& patch) noexcept;

 private:
  ShapedPipeline(const ChainSetup& setup, std::unique_ptr<SlipMethod> method,
                 std::unique_ptr<SurfaceForces> forces);

  const std::unique_ptr<SlipMethod> method_;
  const std::unique_ptr<SurfaceForces> forces_;
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
  const std::unique_ptr<TorqueReading> torque_reading_;
};

// Few taxels: read as a whole, and without a shape under torque.
class FewTaxelsPipeline final : public ShapedPipeline {
 public:
  FewTaxelsPipeline(const ChainSetup& setup, std::unique_ptr<SlipMethod> method);
  double least_sigma() const noexcept override { return kModelSigma; }

 protected:
  std::optional<Reading> read(const Frame& frame, const ContactPatch& patch, const ContactPatch& pulled,
                              const EquivalentPullResult& pull) noexcept override;
};

}  // namespace slipd
