// Frames of displacements → estimates: contact, whether the object slides, alerts; never a margin. Estimate
// thread; allocates in its constructor only.
#pragma once

#include "core/advice/alert.hpp"
#include "core/chain/frame_chain.hpp"
#include "core/chain/setup/setup.hpp"
#include "core/sliding/gel_relaxation.hpp"
#include "core/sliding/sliding_time.hpp"

namespace slipd {

class DisplacementChain final : public FrameChain {
 public:
  // Throws std::invalid_argument unless the layout is a grid of at least 3 x 3 points.
  explicit DisplacementChain(const ChainSetup& setup) : gel_(setup.layout), alert_(setup.alerts) {}

  Method method() const noexcept override { return Method::displacement; }
  const WorkPrecision& tradeoff() const noexcept override { return none_; }
  std::vector<std::string_view> stages() const override { return {"gel_relaxation"}; }
  void set_releasing(bool releasing) noexcept override { gel_.set_releasing(releasing); }
  Estimate estimate(const Frame& frame) noexcept override;

 private:
  const WorkPrecision none_;
  GelRelaxation gel_;
  AlertLogic alert_;
  SlidingTime sliding_time_;
};

}  // namespace slipd
