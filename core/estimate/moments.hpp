// The margin without any training: shear lies further out than pressure, and by how much tells how far slip
// has come in (docs/theory.md §7.1).
//   <r^2>_q / <r^2>_p = (1 - k^5)/(1 - k^3),  Gamma = k^3: 5/3 without load, 1 at gross slip, no friction in
//   it.
#pragma once

#include <limits>

#include "core/estimate/hertz_deviation.hpp"
#include "core/estimate/method.hpp"
#include "core/patch/rings.hpp"

namespace slipd {

// Gamma for a moment ratio; below 1 it is 0, above 5/3 it is 1.
double gamma_of_moment_ratio(double ratio) noexcept;

// Of a whole contact, taken over the patch's disc; deviations as noise in this frame and the size of its
// taxels leave them, infinite for a contact cut by the sensor's edge, or without load.
struct MomentRatio {
  double value = 1, sigma = std::numeric_limits<double>::infinity();
  double load = 0;  // sum q / sum p
  HertzDeviation deviation;
  contact::ShearMoments moments, moments_sigma = FrameEstimate().moments_sigma;
};
MomentRatio moment_ratio(const ContactPatch& patch, const TaxelLayout& layout) noexcept;

class Moments final : public SlipMethod {
 public:
  explicit Moments(const TaxelLayout& layout) : layout_(layout) {}
  Method name() const noexcept override { return Method::moments; }
  MethodSettings settings() const noexcept override {
    return {.memory_bytes = sizeof(*this) + 2 * sizeof(double) * layout_.size()};
  }
  FrameEstimate estimate(const Frame& frame, const ContactPatch& patch) noexcept override;
  FrameEstimate estimate(const ContactPatch& patch,
                         const Rings& rings) const noexcept;  // its rings are known already

 private:
  TaxelLayout layout_;
};

}  // namespace slipd
