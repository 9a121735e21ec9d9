// What EstimatorChain is for sensors of one sort: of pressures and forces, or of displacements.
#pragma once

#include <string_view>
#include <vector>

#include "core/estimate/estimate.hpp"
#include "core/frame/frame.hpp"
#include "core/reading/method/work_precision.hpp"

namespace slipd {

// Each function as in EstimatorChain.
class FrameChain {
 public:
  virtual ~FrameChain() = default;
  virtual Method method() const noexcept = 0;
  virtual const WorkPrecision& tradeoff() const noexcept = 0;
  virtual bool repeats() const noexcept { return false; }
  virtual std::vector<std::string_view> stages() const = 0;
  virtual void set_releasing(bool /*releasing*/) noexcept {}
  virtual Estimate estimate(const Frame& frame) noexcept = 0;
};

}  // namespace slipd
