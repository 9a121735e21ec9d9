#include "bridges/grip_ros2/goals.hpp"

#include <algorithm>

namespace slipd::grip_ros2 {
namespace {

constexpr double kNsPerSecond = 1e9;
// Of unlisted goals that are remembered: a server that refuses all gets one after the other.
constexpr std::size_t kMostUnlisted = 100;

}  // namespace

std::optional<Goal> Goals::due(const Order& order, std::int64_t now_ns) {
  if (order.move == Move::stay) return std::nullopt;
  const bool settled = previous_ == order;
  if (!previous_ || previous_ == sent_order_) changing_since_ns_ = now_ns;
  previous_ = order;
  const auto apart_ns = static_cast<std::int64_t>(kNsPerSecond / settings_.goals_per_s);
  const bool moves = !sent_order_ || sent_order_->move != order.move;
  const bool early = !moves && now_ns - sent_ns_ < apart_ns;
  if (sent_order_ == order && (early || !ignored(now_ns))) return std::nullopt;
  const bool changing = !settled && now_ns - changing_since_ns_ < apart_ns;
  if (order.move != Move::open && (early || changing)) return std::nullopt;
  sent_order_ = order;
  sent_ns_ = now_ns;
  if (order.move == Move::open) return Goal{settings_.open, settings_.open_effort};
  return Goal{settings_.closed, order.force_n * settings_.effort_per_n};
}

void Goals::note_sent(const GoalId& goal, std::int64_t now_ns) {
  unlisted_.push_back({goal, now_ns});
  // The first one stays: it says since when the server lists none.
  if (unlisted_.size() > kMostUnlisted) unlisted_.erase(unlisted_.begin() + 1);
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

bool Goals::late(const Sent& sent, std::int64_t now_ns) const {
  return static_cast<double>(now_ns - sent.time_ns) / kNsPerSecond > settings_.accept_s;
}

bool Goals::ignored(std::int64_t now_ns) const {
  return !unlisted_.empty() && late(unlisted_.back(), now_ns);
}

std::string Goals::trouble(std::int64_t now_ns) const {
  if (refused_)
    return "no goal can be sent: the action's server does not acknowledge those before, or memory is full; "
           "look at its node";
  if (unlisted_.empty() || !late(unlisted_.front(), now_ns)) return {};
  return "the action's server takes no goals: look at its log; if its node runs on another middleware, give "
         "\"middleware\"";
}

}  // namespace slipd::grip_ros2
