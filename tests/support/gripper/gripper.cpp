#include "tests/support/gripper/gripper.hpp"

#include <algorithm>

namespace slipd::gripper {
namespace {

constexpr double kMoreBlindly = 1.1;

double seconds(Time::duration time) noexcept {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

void Fingers::want(double force_n, Time now) {
  orders_.push_back({now + settings_.delay, std::clamp(force_n, 0.0, settings_.most_n)});
}

void Fingers::move(Time until) {
  if (until <= moved_) return;
  const double reach_n = settings_.slew_n_per_s * seconds(until - moved_);
  force_n_ += std::clamp(goal_n_ - force_n_, -reach_n, reach_n);
  moved_ = until;
}

double Fingers::force_n(Time now) {
  for (; !orders_.empty() && orders_.front().at <= now; orders_.pop_front()) {
    move(orders_.front().at);
    goal_n_ = orders_.front().force_n;
  }
  move(now);
  return force_n_;
}

double Controller::step(MarginReceiver& receiver, Time now) {
  const double force_n = fingers_.force_n(now);
  if (const auto call = receiver.take_request()) {
    const double needed_n =
        call->grip_increase_n ? force_n + *call->grip_increase_n : fingers_.wanted_n() * kMoreBlindly;
    if (needed_n > fingers_.wanted_n()) fingers_.want(needed_n, now);
  }
  if (!receiver.margin(now) && fingers_.wanted_n() < settings_.force_n) fingers_.want(settings_.force_n, now);
  return force_n;
}

}  // namespace slipd::gripper
