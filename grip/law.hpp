// How hard to grip: slipd's estimate and the orders of a person in, an order for the gripper out. No clock,
// no descriptors: `now_ns` comes in with each reading. One thread's own.
//
// The pull on the fingers does not depend on the force, so the share of friction that is used is inversely
// proportional to it (docs/theory.md §1.2): a margin g at force F becomes the target t at
// F (1 - g) / (1 - t). F is the force that acted when the sample was taken: what was ordered the gripper's
// delay before.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>

#include "grip/grippers/order.hpp"
#include "grip/load_trend.hpp"
#include "grip/reading.hpp"
#include "grip/transitions.hpp"

namespace slipd::grip {

struct LawSettings {
  // The margin to keep, by gamma_low, 0 … 1. Too small: a tap makes the object slip. Too large: more force
  // than needed.
  double target_margin = 0.4;
  // Whether gamma_low, which holds with 95 % confidence, says how firm is firm while friction is still a
  // range; else firm_n does.
  bool firm_by_low = true;
  // Limits of a finger's force, N; firm_n is what holds whatever comes.
  double least_n = 1, firm_n = 20, most_n = 40;
  // Of the order that closes, N.
  double close_n = 2;
  // The gripper's steps of force, N; 0: none. Orders are rounded up.
  double resolution_n = 0;
  // From an order to the force, s. Too small: the law takes an old margin for the effect of its last order.
  double delay_s = 0.02;
  // How fast an order rises, N/s.
  double raise_n_per_s = 400;
  // How fast it falls, share of the force a second.
  double lower_per_s = 1;
  // For how long a margin has to suffice before the force falls, s.
  double settle_s = 0.5;
  // For how long a reading counts, s: in a longer pause nobody has seen a margin stand.
  double max_age_s = 0.05;
  // What the load grows by and what the margin falls by is foreseen for this long beyond the delay, s.
  double ahead_s = 0.1;
  // Share by which the force may exceed what is needed without being lowered.
  double spare = 0.03;
  // Factor on the force while the object slips.
  double slip_factor = 1.4;
  // A contact that begins is given this long for its first margin, s: the fingers still close, and nothing
  // pulls.
  double contact_s = 0.1;
  // Without a contact for this long the gripper has missed, s.
  double close_timeout_s = 5;
  // Of the fingers that slipd's normal force is the sum of.
  int fingers = 2;
};

enum class Wish : std::uint8_t { none, open, close };
class Law {
 public:
  explicit Law(const LawSettings& settings) : settings_(settings), trend_(kTrendS) {}

  // `now_ns`: of a steady clock that does not go back; a sample's own time where there is one.
  Order step(const Reading& reading, Wish wish, bool gripper_answers, std::int64_t now_ns);

  State state() const noexcept { return state_; }
  // What led to it.
  Event last_event() const noexcept { return event_; }
  double force_n() const noexcept { return order_.force_n; }
  // The margin that the last reading was judged by, 0 if the object would slip by then; nullopt: none.
  std::optional<double> margin() const noexcept {
    return margin_ ? std::optional(std::max(0.0, *margin_)) : std::nullopt;
  }
  // Whether the sensors have felt less than half of the ordered force for half a second.
  bool is_deaf() const noexcept { return deaf_s_ > kDeafAfterS; }

 private:
  static constexpr double kDeafAfterS = 0.5;
  // The load's course that shows how fast it grows, s.
  static constexpr double kTrendS = 0.06;
  struct Past {
    std::int64_t time_ns;
    double force_n;
  };

  std::optional<Event> judge(const Reading& reading, double acting_n);
  void take(Event event, std::int64_t now_ns);
  double wanted_n(const Reading& reading, double acting_n, double passed_s) const;
  double needed_n(double acting_n, double margin) const;
  double firm_n(const Reading& reading, double acting_n) const;
  double foreseen_margin(const Reading& reading) const;
  static double sure_margin(const Reading& reading);
  double acting_n(std::int64_t now_ns);
  double rounded(double force_n) const;
  void watch_deafness(const Reading& reading, double acting_n, double passed_s);

  LawSettings settings_;
  State state_ = State::idle;
  Event event_ = Event::open_order;
  Order order_;
  double force_n_ = 0;  // before it is rounded
  // Whether what acts was ordered by this law, or is nothing: an object may be held since before its start.
  bool force_known_ = false;
  std::deque<Past> past_;
  LoadTrend trend_;
  std::optional<double> margin_;
  std::optional<std::int64_t> now_ns_;
  std::int64_t closing_since_ns_ = 0;
  double contact_for_s_ = 0;
  double settled_s_ = 0;
  double deaf_s_ = 0;
};

}  // namespace slipd::grip
