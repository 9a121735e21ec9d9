// Several fingers hold one object: what they carry together, against what they could carry together
// (docs/theory.md §1.3, §1.4). Estimate thread; plain state, nothing allocated.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/advice/alert.hpp"
#include "core/estimate/estimate.hpp"
#include "core/estimate/settings.hpp"
#include "core/grasp/grasp_load.hpp"
#include "core/sliding/sliding_time.hpp"

namespace slipd {

// `members`: the newest estimates of the grasp's sensors, each with its own friction. What they can carry
// together: gamma = 1 - sum|Q| / sum(mu P), 0 … 1, with Estimate::pull_n for |Q|; forces are sums, friction
// is sum(mu P) / sum P where it was learnt of every finger in contact, the advice is on top of the sum of P.
// All only in state ok, which it is if every member is ok or without contact; else it is the gravest
// member's. A member without contact carries nothing. A member in contact whose forces or limit are unknown
// leaves the whole grasp `learning`. Which slides first: first_gamma and first_member. gamma_low is that of
// the sums as well, and known where every finger's in contact is. No members: stale. Sigmas take the members'
// errors as independent. sequence is the sum of the members', times are the newest. There is no alert and no
// forecast yet.
//
// `poses`: where the members are, one each; then gamma and gamma_low are of forces and torques of the fingers
// on one body (grasp_load.hpp), and pull_n is the share of sum(mu P) that this leaves. None: the sums above.
Estimate grasp_estimate(std::span<const Estimate> members, double target_margin,
                        std::span<const FingerPose> poses = {}) noexcept;

// The same over time: with the alert logic and the forecast of a sensor. The alert is slip where the fingers
// together are near it, or one is seen to slide; at least warn while the alert of a finger is slip, which
// slides first and leaves its load to the others.
class GraspTracker {
 public:
  // `poses`: of the members, or none.
  explicit GraspTracker(const AlertSettings& alerts, std::vector<FingerPose> poses = {})
      : target_margin_(alerts.target_margin), poses_(std::move(poses)), alert_(alerts) {}

  // Whenever a member's estimate is new. Its clock is published_ns, for the members' own clocks may differ.
  Estimate judge(std::span<const Estimate> members) noexcept;

 private:
  std::optional<Sliding> sliding_of(std::span<const Estimate> members) noexcept;

  double target_margin_;
  std::vector<FingerPose> poses_;
  AlertLogic alert_;
  SlipForecast forecast_;
  bool joint_slide_ = false;  // all fingers together show a slide
  SlidingTime sliding_time_;
};

}  // namespace slipd
