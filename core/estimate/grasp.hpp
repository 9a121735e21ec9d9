// Several fingers hold one object: what they carry together, against what they could carry together.
#pragma once

#include <optional>
#include <span>

#include "core/estimate/estimate.hpp"
#include "core/estimate/settings.hpp"

namespace slipd {

struct GraspMargin {
  State state = State::stale;   // ok only if every member is ok or without contact; else the gravest member's
  std::optional<double> gamma;  // 1 - sum |Q| / sum(mu P), 0 … 1; only in state ok
  std::optional<double> normal_n;  // sum of P; the next two likewise only in state ok
  std::optional<double> shear_n;   // sum of |Q|
  std::optional<double> friction;  // sum(mu P) / sum P
  std::optional<double>
      grip_increase_n;        // on top of the sum of P, to reach target_margin; 0 if it is reached
  Alert alert = Alert::none;  // by the thresholds of `alerts`, for this instant
};

// `members`: the newest estimates of the grasp's sensors. A member without contact carries nothing. A member
// in contact whose forces or friction are unknown leaves the whole grasp `learning`. No members: stale.
GraspMargin grasp_margin(std::span<const Estimate> members, const AlertSettings& alerts) noexcept;

}  // namespace slipd
