#include "core/estimate/grasp.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {

Estimate grasp_estimate(std::span<const Estimate> members, double target_margin) noexcept {
  Estimate result;
  if (members.empty()) return result;
  State gravest = State::ok;
  bool contact = false;
  double normal_n = 0, shear_n = 0, pull_n = 0;
  double limit_n = 0, limit_variance = 0;  // sum of mu P
  for (const Estimate& member : members) {
    result.sequence += member.sequence;
    result.time_ns = std::max(result.time_ns, member.time_ns);
    result.published_ns = std::max(result.published_ns, member.published_ns);
    if (member.state == State::no_contact) continue;
    State state = member.state;
    if (state == State::ok) {
      contact = true;
      if (member.friction && member.normal_n && member.shear_n) {
        normal_n += *member.normal_n;
        shear_n += std::abs(*member.shear_n);
        pull_n += member.pull_n.value_or(std::abs(*member.shear_n));
        limit_n += *member.friction * *member.normal_n;
        const double error_n = member.friction_sigma.value_or(0) * *member.normal_n;
        limit_variance += error_n * error_n;
      } else {
        state = State::learning;
      }
    }
    gravest = std::max(gravest, state);
  }
  result.state = gravest == State::ok && !contact ? State::no_contact : gravest;
  if (result.state == State::ok && !(limit_n > 0)) result.state = State::learning;
  if (result.state != State::ok) return result;

  const double limit_sigma_n = std::sqrt(limit_variance);
  result.gamma = std::clamp(1 - pull_n / limit_n, 0.0, 1.0);
  result.sigma = pull_n / limit_n * limit_sigma_n / limit_n;
  result.normal_n = normal_n;
  result.shear_n = shear_n;
  result.pull_n = pull_n;
  result.friction = limit_n / normal_n;
  result.friction_sigma = limit_sigma_n / normal_n;
  advise(result, 0, target_margin);
  return result;
}

Estimate GraspTracker::judge(std::span<const Estimate> members) noexcept {
  Estimate now = grasp_estimate(members, target_margin_);
  now.alert = alert_.update(now.published_ns, now);
  now.alert_cause = now.alert == Alert::none ? AlertCause::none : AlertCause::margin;
  for (const Estimate& member : members) {
    if (!slides(member.sliding)) continue;
    now.sliding = member.sliding;
    now.sliding_for_s = std::max(now.sliding_for_s.value_or(0), member.sliding_for_s.value_or(0));
    if (now.alert == Alert::slip) continue;
    now.alert = Alert::slip;
    now.alert_cause = AlertCause::sliding;
  }
  now.time_to_slip_s = forecast_.update(now.published_ns, now.gamma, now.sigma.value_or(0));
  return now;
}

}  // namespace slipd
