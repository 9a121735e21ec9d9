#include "bridges/grip_ros2/goals.hpp"

#include <algorithm>

namespace slipd::grip_ros2 {
namespace {

constexpr double kNsPerSecond = 1e9;

}  // namespace

std::optional<Goal> Goals::due(const Order& order, std::int64_t now_ns) {
  if (order.move == Move::stay) return std::nullopt;
  const bool settled = previous_ == order;
  if (!previous_ || previous_ == sent_order_) changing_since_ns_ = now_ns;
  previous_ = order;
  if (sent_order_ == order) return std::nullopt;
  const auto apart_ns = static_cast<std::int64_t>(kNsPerSecond / settings_.goals_per_s);
  const bool moves = !sent_order_ || sent_order_->move != order.move;
  const bool early = !moves && now_ns - sent_ns_ < apart_ns;
  const bool changing = !settled && now_ns - changing_since_ns_ < apart_ns;
  if (order.move != Move::open && (early || changing)) return std::nullopt;
  sent_order_ = order;
  sent_ns_ = now_ns;
  if (order.move == Move::open) return Goal{settings_.open, settings_.open_effort};
  return Goal{settings_.closed, order.force_n * settings_.effort_per_n};
}

void Goals::note_sent(const GoalId& goal, std::int64_t now_ns) {
  unlisted_.push_back({goal, now_ns});
  newest_ = goal;
  aborted_ = refused_ = false;
}

void Goals::note_refused() {
  sent_order_.reset();
  refused_ = true;
}

void Goals::note_listed(const GoalStatus& status) {
  if (status.goal_id == newest_) aborted_ = status.status == GoalStatus::kAborted;
  const auto found = std::ranges::find(unlisted_, status.goal_id, &Sent::goal);
  if (found != unlisted_.end()) unlisted_.erase(unlisted_.begin(), found + 1);
}

void Goals::forget() {
  sent_order_.reset();
  unlisted_.clear();
  aborted_ = refused_ = false;
}

std::string Goals::trouble(std::int64_t now_ns) const {
  if (refused_)
    return "no goal can be sent: the action's server does not acknowledge those before, or memory is full; "
           "look at its node";
  if (unlisted_.empty()) return {};
  const double since_s = static_cast<double>(now_ns - unlisted_.front().time_ns) / kNsPerSecond;
  if (since_s <= settings_.accept_s) return {};
  return "the action's server takes no goals: look at its log; if its node runs on another middleware, give "
         "\"middleware\"";
}

}  // namespace slipd::grip_ros2
