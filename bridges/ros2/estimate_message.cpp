#include "bridges/ros2/estimate_message.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "bridges/ros2/messages/sensor_messages.hpp"
#include "bridges/support/clock.hpp"
#include "clients/c/alert.hpp"

namespace slipd::ros2 {

namespace {

// Two clocks that are read within this time are of one moment, ns. An interruption between them would be an
// error of each stamp that is made from both.
constexpr std::int64_t kOneMomentNs = 2'000;
constexpr int kMostReadings = 4;

}  // namespace

Moment Moment::now() noexcept {
  Moment best{};
  std::int64_t least_ns = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < kMostReadings && least_ns > kOneMomentNs; ++i) {
    const Moment moment{bridges::monotonic_ns(), bridges::realtime_ns()};
    const std::int64_t took_ns = bridges::monotonic_ns() - moment.monotonic_ns;
    if (took_ns < least_ns) best = moment;
    least_ns = std::min(least_ns, took_ns);
  }
  return best;
}

std::int64_t realtime_of_sample(const slipd_estimate& from, const Moment& now) noexcept {
  return from.realtime_ns != 0 ? from.realtime_ns : now.realtime_ns - (now.monotonic_ns - from.time_ns);
}

void fill_message(const slipd_estimate& from, const Moment& now, SlipEstimate& to) {
  to.header.stamp = time_of(from.time_ns == 0 ? now.realtime_ns : realtime_of_sample(from, now));
  to.name = from.name;
  to.state = static_cast<std::uint8_t>(from.state);
  to.alert = static_cast<std::uint8_t>(from.alert);
  to.sliding = static_cast<std::uint8_t>(from.sliding);
  to.simulated = from.simulated != 0;
  to.seq = from.sequence;
  to.dropped = from.dropped;
  to.age = from.age_s;
  to.margin = slipd_margin(&from);
  to.margin_sigma = from.sigma;
  to.margin_low = from.gamma_low;
  to.friction = from.friction;
  to.friction_sigma = from.friction_sigma;
  to.normal_force = from.normal_n;
  to.shear_force = from.shear_n;
  to.shear_force_x = from.shear_x_n;
  to.shear_force_y = from.shear_y_n;
  to.torque = from.torque_nm;
  to.torque_sigma = from.torque_sigma_nm;
  to.center_x = from.center_x_m;
  to.center_y = from.center_y_m;
  to.radius = from.radius_m;
  to.time_to_slip = from.time_to_slip_s;
  to.grip_increase = from.grip_increase_n;
  to.grip_increase_sigma = from.grip_increase_sigma_n;
  to.sliding_for = from.sliding_for_s;
}

void clear_message(std::uint8_t state, const Moment& now, SlipEstimate& to) {
  SlipEstimate none;
  none.name = std::move(to.name);
  none.header.frame_id = std::move(to.header.frame_id);
  none.header.stamp = time_of(now.realtime_ns);
  none.state = state;
  none.alert = static_cast<std::uint8_t>(client::without_frames(to.alert));
  none.simulated = to.simulated;
  none.seq = to.seq;
  to = std::move(none);
}

}  // namespace slipd::ros2
