// Frame → Estimate for one sensor. The one door through which the daemon and the tools reach the estimators.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "core/chain/setup/setup.hpp"
#include "core/estimate/estimate.hpp"
#include "core/frame/frame.hpp"

namespace slipd {

class FrameChain;      // core/chain/frame_chain.hpp
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

  // Estimate thread. The robot says whether it lets go of the object, from the next frame on. Then a sensor
  // of displacements shows no slide: an object that is set down looks like one that is lost. Other sensors'
  // estimates do not depend on it.
  void set_releasing(bool releasing) noexcept;

  // Estimate thread. Allocates nothing. `frame`'s spans have the layout's size; frames come in order of time.
  Estimate estimate(const Frame& frame) noexcept;

  // Whether the last frame was the one before it, which some sensor read something in: no new measurement.
  bool repeats() const noexcept;

 private:
  std::unique_ptr<FrameChain> chain_;
};

}  // namespace slipd
