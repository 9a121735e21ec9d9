// Frame → Estimate for one sensor. The one door through which the daemon and the tools reach the estimators.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "core/chain/setup.hpp"
#include "core/estimate/estimate.hpp"
#include "core/frame/frame.hpp"

namespace slipd {

class TrainedModel;    // core/reading/method/trained_model.hpp
struct WorkPrecision;  // core/reading/method/work_precision.hpp

class EstimatorChain {
 public:
  // `model` may be null where needs_model says no. Throws std::invalid_argument for a model of another
  // layout, or a method that this sensor cannot carry.
  EstimatorChain(const ChainSetup& setup, const std::shared_ptr<const TrainedModel>& model);
  EstimatorChain(EstimatorChain&&) noexcept;
  EstimatorChain& operator=(EstimatorChain&&) noexcept;
  ~EstimatorChain();

  Method method() const noexcept;  // the one that was chosen

  // Error against run time on this scene: what the choice was made from for method `automatic`, for a trained
  // method what was measured with its model. No rows for others.
  const WorkPrecision& tradeoff() const noexcept;

  // What this sensor's frames pass through, in order: the names of the stages that were constructed. Set-up.
  std::vector<std::string_view> stages() const;

  // Estimate thread. Allocates nothing. `frame`'s spans have the layout's size; frames come in order of time.
  Estimate estimate(const Frame& frame) noexcept;

  // Whether the last frame was the one before it, which some sensor read something in: no new measurement.
  bool repeats() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace slipd
