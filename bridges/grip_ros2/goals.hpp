// Which goals an action for grippers gets, and whether it takes them: the rules, without DDS and without a
// clock. One thread's own.
//
// slipd-grip gives an order for each estimate, hundreds a second, and lets forces rise over some of them; an
// action's server lists each goal for as long as 15 minutes and gives up the one before. So a changed order
// becomes a goal when it is the same twice in a row, or has gone on changing for as long as goals are apart,
// and goals come at a rate at most. Opening comes at once.
//
// No reply is waited for: on the wire it does not say whom it answers. That a goal was accepted shows in the
// list of goals that the server publishes. One that does not show there in time is sent again, for as long as
// its order stands.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "bridges/grip_ros2/messages.hpp"

namespace slipd::grip_ros2 {

enum class Move : std::uint8_t { stay, open, grip };

struct Order {
  Move move = Move::stay;
  double force_n = 0;  // of each finger; of Move::grip
  bool operator==(const Order&) const = default;
};

struct GoalSettings {
  // Where the gripper is open and closed, in the unit of its driver; different numbers.
  double open = 0.085, closed = 0;
  // max_effort for each newton of a finger. More: the gripper is stronger than its orders.
  double effort_per_n = 1;
  // Of opening, in the unit of max_effort.
  double open_effort = 10;
  // Goals a second at most, above 0. Too few: forces come late. Too many: the server's list grows.
  double goals_per_s = 10;
  // How long a goal may take until the server lists it, s, above 0. After it the goal is sent again.
  double accept_s = 1;
};

struct Goal {
  double position = 0, effort = 0;
};

class Goals {
 public:
  explicit Goals(const GoalSettings& settings) : settings_(settings) {}

  // The goal that has to be sent now for an order; none: the last one stands. The same one again if the
  // server does not list it in time. `now_ns`: of a steady clock.
  std::optional<Goal> due(const Order& order, std::int64_t now_ns);
  // The goal that was due was sent; or DDS refused it, and it is due again with the next order.
  void note_sent(const GoalId& goal, std::int64_t now_ns);
  void note_refused();
  // The server lists a goal.
  void note_listed(const GoalStatus& status);
  // There is another server, or none: what was sent counts for nothing.
  void forget();
  // For people: why no goal is carried out; empty: nothing is known against it.
  std::string trouble(std::int64_t now_ns) const;
  // Whether the newest goal was given up by the server; cleared by the next goal. Servers do so, too, when
  // the fingers stall on an object, and hold it.
  bool aborted() const noexcept { return aborted_; }

 private:
  struct Sent {
    GoalId goal;
    std::int64_t time_ns;
  };

  bool late(const Sent& sent, std::int64_t now_ns) const;
  // Whether the server does not list the newest goal in time.
  bool ignored(std::int64_t now_ns) const;

  GoalSettings settings_;
  std::optional<Order> sent_order_;
  std::int64_t sent_ns_ = 0;
  std::optional<Order> previous_;       // line by line
  std::int64_t changing_since_ns_ = 0;  // since when orders differ from the one that was sent
  std::deque<Sent> unlisted_;           // in their order
  GoalId newest_;
  bool aborted_ = false;
  bool refused_ = false;  // the last one that was due
};

}  // namespace slipd::grip_ros2
