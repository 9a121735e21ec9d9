#include "core/estimate/grasp.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {

GraspMargin grasp_margin(std::span<const Estimate> members, const AlertSettings& alerts) noexcept {
  GraspMargin result;
  if (members.empty()) return result;
  State gravest = State::ok;
  bool contact = false;
  double normal = 0;
  double shear = 0;
  double limit = 0;  // sum of mu P
  for (const Estimate& member : members) {
    if (member.state == State::no_contact) continue;
    State state = member.state;
    if (state == State::ok) {
      contact = true;
      if (member.friction && member.normal_n && member.shear_n) {
        normal += *member.normal_n;
        shear += std::abs(*member.shear_n);
        limit += *member.friction * *member.normal_n;
      } else {
        state = State::learning;
      }
    }
    gravest = std::max(gravest, state);
  }
  result.state = gravest == State::ok && !contact ? State::no_contact : gravest;
  if (result.state == State::ok && !(limit > 0)) result.state = State::learning;
  if (result.state != State::ok) return result;

  const double gamma = std::clamp(1 - shear / limit, 0.0, 1.0);
  const double friction = limit / normal;
  result.gamma = gamma;
  result.normal_n = normal;
  result.shear_n = shear;
  result.friction = friction;
  if (alerts.target_margin < 1) {
    result.grip_increase_n = std::max(0.0, shear / (friction * (1 - alerts.target_margin)) - normal);
  }
  if (gamma < alerts.warn_below) result.alert = Alert::warn;
  if (gamma < alerts.slip_below) result.alert = Alert::slip;
  return result;
}

}  // namespace slipd
