// The one place that writes a frame's margin. Stages of a pipeline say what they know: a margin and how sure
// it is, what makes it less sure, why there is none, below what it is not. apply() weighs all of it once.
// Estimate thread; plain state, nothing allocates.
#pragma once

#include <optional>

#include "core/estimate/estimate.hpp"
#include "core/frame/model_errors.hpp"
#include "core/numeric/posterior_sums.hpp"

namespace slipd {

class MarginDecision {
 public:
  // Of one frame. sigma_max: Gamma, > 0; a margin that is less sure means nothing: state learning.
  // least_sigma: Gamma, >= 0, what no frame of this sensor is surer than. `refused`: of sensors that never
  // have a margin, why.
  explicit MarginDecision(double sigma_max, double least_sigma = kExactShare,
                          std::optional<State> refused = std::nullopt) noexcept
      : sigma_max_(sigma_max), least_sigma_(least_sigma), refused_(refused) {}

  // The margin, dimensionless, with its standard deviation by friction and by this frame.
  void propose(MeanSigma margin) noexcept;
  // There is no margin. The first reason stands: a stage that comes later adds nothing to it.
  void refuse(State why) noexcept;
  // The sensor is at fault: stronger than any reason to refuse.
  void fail() noexcept { failed_ = true; }
  // Something else leaves the margin open by this standard deviation, Gamma, >= 0, independent of the rest.
  void widen(double sigma) noexcept;

  // With 95 % confidence friction is above this, mu >= 0.
  void rely_on(double least_friction) noexcept { least_friction_ = least_friction; }
  // As said last; nothing: frames do not show it.
  std::optional<double> least_friction() const noexcept { return least_friction_; }

  // The margin that holds with 95 % confidence by forces and friction, 0 to 1. With a margin that stands,
  // that one's own lower end counts as well.
  void bound(double low) noexcept { low_ = low; }
  // Share of the force that neighbours stand for, 0 to 1: as uncertain as it is large.
  void leave_out(double share) noexcept;

  // The object is seen to slide: a margin above `slip_below` contradicts that and is none; nothing is held
  // for sure.
  void slide(double slip_below) noexcept;

  // Whether there is a margin, as far as stages have said.
  bool stands() const noexcept;
  // The margin that was proposed, if it stands.
  std::optional<MeanSigma> margin() const noexcept;

  // Writes state, gamma, sigma and gamma_low. Where the margin may be 0, that the object was not seen to
  // slide says nothing: `sliding` none is then unknown.
  void apply(Estimate& out) const noexcept;

 private:
  double sigma() const noexcept;

  const double sigma_max_, least_sigma_;
  std::optional<State> refused_;
  bool failed_ = false;
  std::optional<MeanSigma> margin_;
  double widened_ = 0;   // standard deviation by all that is independent of the margin's own
  double left_out_ = 0;  // share
  std::optional<double> least_friction_, low_;
};

}  // namespace slipd
