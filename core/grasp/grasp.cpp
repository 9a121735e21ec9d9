#include "core/grasp/grasp.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace slipd {
namespace {

// What the fingers carry together, and can carry; N.
struct Sums {
  double normal_n = 0, shear_n = 0, pull_n = 0;
  double limit_n = 0, limit_variance = 0;  // of sum of mu P
  double limit_low_n = 0;
  bool contact = false;
  bool friction_known = true;  // of all fingers in contact
  bool low_known = true;       // the same
};

// mu P of a finger whose margin is known, and its variance; false: it is not known.
bool add_limit(const Estimate& member, Sums& sums) noexcept {
  if (!member.normal_n || !member.shear_n) return false;
  if (member.limit_n) {
    const double sigma_n = member.limit_sigma_n.value_or(0);
    sums.limit_n += *member.limit_n;
    sums.limit_variance += sigma_n * sigma_n;
  } else if (member.friction) {
    const double sigma_n = member.friction_sigma.value_or(0) * *member.normal_n;
    sums.limit_n += *member.friction * *member.normal_n;
    sums.limit_variance += sigma_n * sigma_n;
  } else {
    return false;
  }
  sums.friction_known = sums.friction_known && member.friction;
  return true;
}

void add_forces(const Estimate& member, Sums& sums) noexcept {
  sums.contact = true;
  sums.low_known = sums.low_known && member.gamma_low && member.limit_low_n;
  sums.limit_low_n += member.limit_low_n.value_or(0);
  if (!member.normal_n || !member.shear_n) {
    sums.low_known = false;
    return;
  }
  sums.normal_n += *member.normal_n;
  sums.shear_n += std::abs(*member.shear_n);
  sums.pull_n += member.pull_n.value_or(std::abs(*member.shear_n));
}

// What the fingers in contact carry on one body, with their limits or those on the safe side. Fingers that
// are not in contact hold nothing.
GraspLoad load_on_body(std::span<const Estimate> members, std::span<const FingerPose> poses,
                       bool low) noexcept {
  std::array<FingerLoad, GraspLoad::kMost> fingers;
  const std::size_t count = std::min({members.size(), poses.size(), fingers.size()});
  for (std::size_t i = 0; i < count; ++i) {
    const Estimate& member = members[i];
    FingerLoad& finger = fingers[i];
    finger.pose = poses[i];
    if (member.state == State::no_contact || !member.normal_n || !member.shear_n) continue;
    finger.center_x_m = member.center_x_m.value_or(0);
    finger.center_y_m = member.center_y_m.value_or(0);
    finger.shear_x_n = member.shear_x_n.value_or(*member.shear_n);
    finger.shear_y_n = member.shear_y_n.value_or(0);
    // A torque that noise may be all of does not count, as in the finger's own margin.
    if (member.pull_n && *member.pull_n > std::abs(*member.shear_n))
      finger.torque_nm = member.torque_nm.value_or(0);
    finger.radius_m = member.radius_m.value_or(0);
    finger.limit_n = low ? member.limit_low_n.value_or(0)
                         : member.limit_n.value_or(member.friction.value_or(0) * *member.normal_n);
  }
  return grasp_load(std::span(fingers).first(count));
}

// Of the margin, by the limits of the fingers.
double sigma_on_body(std::span<const Estimate> members, const GraspLoad& load) noexcept {
  double variance = 0;
  for (std::size_t i = 0; i < std::min(members.size(), GraspLoad::kMost); ++i) {
    const Estimate& member = members[i];
    const double sigma_n = member.limit_n ? member.limit_sigma_n.value_or(0)
                                          : member.friction_sigma.value_or(0) * member.normal_n.value_or(0);
    variance += std::pow(load.per_limit_n[i] * sigma_n, 2);
  }
  return std::sqrt(variance);
}

// What fingers whose sensors measure displacements see of the object.
void add_displacement(const Estimate& member, Estimate& result) noexcept {
  if (!member.slide_evidence) return;
  result.slide_evidence = std::max(*member.slide_evidence, result.slide_evidence.value_or(0));
  if (member.displacement_m)
    result.displacement_m = std::max(*member.displacement_m, result.displacement_m.value_or(0));
}

// Whether a finger touches; none: of one it is not known, and no other does.
std::optional<bool> contact_of(std::span<const Estimate> members) noexcept {
  const auto any = [&](std::optional<bool> contact) {
    return std::ranges::any_of(members, [&](const Estimate& member) { return member.contact == contact; });
  };
  if (any(true)) return true;
  return any(std::nullopt) ? std::nullopt : std::optional(false);
}

void give_margin(const Sums& sums, double target_margin, Estimate& result) noexcept {
  const double limit_sigma_n = std::sqrt(sums.limit_variance);
  result.gamma = std::clamp(1 - sums.pull_n / sums.limit_n, 0.0, 1.0);
  result.sigma = sums.pull_n / sums.limit_n * limit_sigma_n / sums.limit_n;
  result.normal_n = sums.normal_n;
  result.shear_n = sums.shear_n;
  result.pull_n = sums.pull_n;
  result.limit_n = sums.limit_n;
  result.limit_sigma_n = limit_sigma_n;
  if (!sums.friction_known) return;
  result.friction = sums.limit_n / sums.normal_n;
  result.friction_sigma = limit_sigma_n / sums.normal_n;
  advise(result, 0, target_margin);
}

}  // namespace

Estimate grasp_estimate(std::span<const Estimate> members, double target_margin,
                        std::span<const FingerPose> poses) noexcept {
  Estimate result;
  if (members.empty()) return result;
  State gravest = State::ok;
  Sums sums;
  result.health = Health::good;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Estimate& member = members[i];
    if (!is_implausible(result.health) && member.health != Health::good) result.health = member.health;
    result.sequence += member.sequence;
    result.time_ns = std::max(result.time_ns, member.time_ns);
    result.published_ns = std::max(result.published_ns, member.published_ns);
    add_displacement(member, result);
    if (member.state == State::no_contact) continue;
    add_forces(member, sums);
    State state = member.state;
    if (state == State::ok && !add_limit(member, sums)) state = State::learning;
    gravest = std::max(gravest, state);
    if (!member.gamma || (result.first_gamma && *member.gamma >= *result.first_gamma)) continue;
    result.first_gamma = member.gamma;
    result.first_member = static_cast<std::uint8_t>(i);
  }
  result.contact = contact_of(members);
  result.state = gravest == State::ok && !sums.contact ? State::no_contact : gravest;
  if (result.state == State::ok && !(sums.limit_n > 0)) result.state = State::learning;
  const bool on_body = poses.size() == members.size();
  if (sums.contact && sums.low_known && gravest <= State::out_of_model) {
    if (on_body && sums.limit_low_n > 0)
      sums.pull_n = sums.limit_low_n * load_on_body(members, poses, true).used_share;
    result.limit_low_n = sums.limit_low_n;
    result.gamma_low = sums.limit_low_n > 0 ? std::clamp(1 - sums.pull_n / sums.limit_low_n, 0.0, 1.0) : 0;
  }
  if (result.state != State::ok) return result;
  const GraspLoad load = on_body ? load_on_body(members, poses, false) : GraspLoad{};
  if (on_body) sums.pull_n = sums.limit_n * load.used_share;
  give_margin(sums, target_margin, result);
  if (on_body) result.sigma = sigma_on_body(members, load);
  return result;
}

// What the fingers in contact see of the one object that they hold. A finger that slides is enough. Where no
// pattern has moved far enough for a finger alone, all together may: their errors are not the same, so that
// the mean of n deviates by 1/sqrt(n) of one's. A slide that was seen so ends when it is not seen by half of
// that.
std::optional<Sliding> GraspTracker::sliding_of(std::span<const Estimate> members) noexcept {
  constexpr double kMost = std::numeric_limits<double>::infinity();
  Sliding worst = Sliding::none;
  bool known = true, seen = false;
  std::size_t fingers = 0, patterns = 0;
  double moved = 0, along = 0, least = kMost, torque_least = kMost, torque_most = -kMost;
  for (const Estimate& member : members) {
    if (member.state == State::no_contact) continue;
    ++fingers;
    known = known && member.sliding;
    worst = std::max(worst, member.sliding.value_or(Sliding::none));
    seen = seen || slides(member.sliding);
    if (!member.pattern) continue;
    ++patterns;
    moved += member.pattern->moved;
    least = std::min(least, member.pattern->moved);
    along += member.pattern->along;
    torque_most = std::max(torque_most, member.pattern->torque);
    torque_least = std::min(torque_least, member.pattern->torque);
  }
  const auto n = static_cast<double>(fingers);
  const bool joined = fingers > 1 && patterns == fingers;
  const double limit = 1 / std::sqrt(n), needed = joint_slide_ ? limit / 2 : limit;
  joint_slide_ = joined && moved / n > needed && least > needed / 2;
  if (seen || joint_slide_) {
    if (!joined) return std::max(worst, Sliding::translation);
    // Sensors that face each other sense one turn in opposite senses, and what is common to all is no turn.
    const bool turns = torque_most - torque_least > along;
    return turns ? Sliding::rotation : Sliding::translation;
  }
  if (fingers == 0 || !known) return std::nullopt;
  return worst;
}

Estimate GraspTracker::judge(std::span<const Estimate> members) noexcept {
  Estimate now = grasp_estimate(members, target_margin_, poses_);
  now.sliding = sliding_of(members);
  now.sliding_for_s = sliding_time_.update(now.sliding, now.published_ns);
  // What nobody watches its fingers say.
  now.alert = alert_.update(now.published_ns, now, true);
  for (const Estimate& member : members) {
    if (member.alert == Alert::unknown && !now.gamma) now.alert = without_frames(now.alert);
    // A finger that slides leaves the load to the others: no slip yet of what they hold, if they can.
    if (member.alert == Alert::slip && member.state != State::no_contact && now.alert != Alert::slip)
      now.alert = Alert::warn;
  }
  now.alert_cause = is_raised(now.alert) ? AlertCause::margin : AlertCause::none;
  if (slides(now.sliding)) {
    if (now.gamma_low) now.gamma_low = 0;
    if (now.alert != Alert::slip) now.alert_cause = AlertCause::sliding;
    now.alert = Alert::slip;
  }
  now.time_to_slip_s = forecast_.update(now.published_ns, now.gamma, now.sigma.value_or(0));
  return now;
}

}  // namespace slipd
