// The margin without any training: shear lies farther out than pressure, and by how much shows how far slip
// has come in (docs/methods.md §22).
//   <r^2>_q / <r^2>_p = (1 - k^5)/(1 - k^3),  Gamma = k^3: 5/3 without load, 1 at gross slip, no friction in
//   it.
#pragma once

#include <limits>

#include "core/patch/hertz_deviation.hpp"
#include "core/patch/rings.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {

// Gamma for a moment ratio; below 1 it is 0, above 5/3 it is 1.
double gamma_of_moment_ratio(double ratio) noexcept;

// Its slope: 1 at gross slip … 9/5 without load. k: the stick zone's radius over the contact's, cbrt(Gamma),
// 0 … 1.
double gamma_per_moment_ratio(double k) noexcept;

// All dimensionless. Checked with `slipd-lab tradeoff --no-models`, rows of moments: sigma is right where 68
// % of the answers are within it. side: a taxel's side; a: the contact's radius.
struct MomentRatioOptions {
  HertzDeviationOptions deviation;

  // Error of the ratio by square taxels on a round rim, over (side/a)^3, and on shear that lies in a ring at
  // the rim narrower than a taxel, under a light load, over (side/a)^2; 0 … 1. Measured by quadrature of
  // exact tractions over side/a of 0.06 … 0.9. Too small: sigma is less than the error on coarse arrays. Too
  // large: it is more.
  double rim_error = 0.3;
  // The ring's width (1 - k) a at which half of the latter is left, over side; 0.1 … 1. Too small and too
  // large: as above, of light loads.
  double ring_width = 0.45;
  // Share of both that is left where GridAliasing corrects the ratio: regular grids without a dead taxel in
  // the contact; 0.15 … 1. The correction itself leaves 0.15; the rest is for taxels that do not sense
  // exactly the mean over their square. Too small: sigma is less than the error after a regrip or an
  // unloading (`slipd-lab coverage --grasps 30 --of histories`). Too large: alerts come early.
  double corrected_share = 0.6;
  // Floor of the shear moments' sigmas, of the shear; 0 … 0.02. Too small: the friction filter believes one
  // frame. Too large: it learns slowly.
  double moments_floor = 0.002;
};

// Of a whole contact, taken over the patch's disc.
struct MomentRatio {
  // <r^2>_q / <r^2>_p, dimensionless; 1 where there is no shear or no pressure.
  double value = 1;
  // Its standard deviation, by noise of this frame and the taxels' size; infinite for a contact cut by the
  // sensor's edge, or without load.
  double sigma = std::numeric_limits<double>::infinity();
  // The margin of a monotonic load with this ratio, 0 … 1.
  double gamma = 0;
  // Sum q / sum p, dimensionless; 0 without load.
  double load = 0;
  // How the pressure differs from Hertz's; zero for a contact cut by the edge.
  HertzDeviation deviation;
  // Moments of the shear about the centre, N, signed along the resultant.
  contact::ShearMoments moments;
  // Their standard deviations, N; infinite as `sigma` is.
  contact::ShearMoments moments_sigma = Reading().moments_sigma;
  // The part of `sigma` that is the same in each frame of a contact: of the taxels' size.
  double common_sigma = 0;
  // The same of `moments_sigma`, N.
  contact::ShearMoments moments_common_sigma;
};
MomentRatio moment_ratio(const ContactPatch& patch, const TaxelLayout& layout,
                         const MomentRatioOptions& options = {}) noexcept;

class Moments final : public SlipMethod {
 public:
  explicit Moments(const TaxelLayout& layout, const MomentRatioOptions& options = {})
      : layout_(layout), options_(options) {}
  Method name() const noexcept override { return Method::moments; }
  MethodSettings settings() const noexcept override {
    return {.memory_bytes = sizeof(*this) + 2 * sizeof(double) * layout_.size()};
  }
  Reading estimate(const Frame& frame, const ContactPatch& patch) noexcept override;
  // The same where the patch's rings are known already.
  Reading estimate(const ContactPatch& patch, const Rings& rings) const noexcept;

 private:
  const TaxelLayout layout_;
  const MomentRatioOptions options_;
};

}  // namespace slipd
