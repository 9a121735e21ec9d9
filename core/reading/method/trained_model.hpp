// What the chain needs of a method that was trained for one sensor and scene. The paper's method is one
// (paper/model/model.hpp), and a library that is loaded only where a scene names it.
#pragma once

#include <memory>

#include "core/frame/layout.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/method/work_precision.hpp"

namespace slipd {

// Immutable; any thread. Always owned by a std::shared_ptr.
class TrainedModel {
 public:
  virtual ~TrainedModel() = default;
  // The layout that it was trained for.
  virtual const TaxelLayout& layout() const noexcept = 0;
  // Error against run time as measured when it was trained; no rows where nobody measured.
  virtual const WorkPrecision& work_precision() const noexcept = 0;
  // A method that reads frames by it and keeps it alive. Set-up; allocates.
  virtual std::unique_ptr<SlipMethod> make_method() const = 0;
};

}  // namespace slipd
