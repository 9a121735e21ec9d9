#include "grip/law.hpp"

#include <algorithm>
#include <cmath>

namespace slipd::grip {
namespace {

constexpr double kNsPerSecond = 1e9;
// Of the least force that a missing object could be mistaken for, N.
constexpr double kDeafFromN = 1;

}  // namespace

Order Law::step(const Reading& reading, Wish wish, bool gripper_answers, std::int64_t now_ns) {
  now_ns = std::max(now_ns, now_ns_.value_or(now_ns));
  const double since_s = static_cast<double>(now_ns - now_ns_.value_or(now_ns)) / kNsPerSecond;
  const bool paused = since_s > settings_.max_age_s;
  const double passed_s = std::min(since_s, settings_.max_age_s);
  now_ns_ = now_ns;
  const double acting = acting_n(now_ns);
  contact_for_s_ = reading.contact == true ? contact_for_s_ + passed_s : 0;
  trend_.add(now_ns, reading.shear_n);
  margin_ = reading.known ? std::optional(foreseen_margin(reading)) : std::nullopt;

  if (reading.contact == false) force_known_ = true;
  const bool finds = state_ == State::idle && reading.contact == true;  // before any order to close
  if (finds) take(Event::contact, now_ns);
  if (wish != Wish::none) take(wish == Wish::open ? Event::open_order : Event::close_order, now_ns);
  take(gripper_answers ? Event::gripper_back : Event::gripper_gone, now_ns);
  if (const auto event = finds ? std::nullopt : judge(reading, acting)) take(*event, now_ns);
  if (static_cast<double>(now_ns - closing_since_ns_) > settings_.close_timeout_s * kNsPerSecond)
    take(Event::no_object, now_ns);

  const bool stands = state_ == State::holding && margin_ >= settings_.target_margin;
  settled_s_ = stands && !paused ? settled_s_ + passed_s : 0;
  watch_deafness(reading, acting, passed_s);
  if (state_ == State::open) {
    force_n_ = 0;
    order_ = {.move = Move::open};
  } else if (state_ != State::idle) {
    force_n_ = wanted_n(reading, acting, passed_s);
    order_ = {.move = Move::grip, .force_n = rounded(force_n_)};
  }
  force_known_ |= state_ != State::idle;
  past_.push_back({now_ns, order_.force_n});
  return order_;
}

std::optional<Event> Law::judge(const Reading& reading, double acting) {
  const bool fresh = state_ == State::closing && contact_for_s_ < settings_.contact_s;
  const bool touches =
      is_gripping(state_) || (state_ == State::closing && reading.contact == true && margin_);
  if (!touches) {
    if (reading.contact == true) return fresh ? std::nullopt : std::optional(Event::contact);
    const bool blind = state_ == State::closing && !reading.contact;
    return blind ? std::optional(Event::margin_unknown) : std::nullopt;
  }
  if (reading.slips) return Event::slip;
  if (!margin_) return Event::margin_unknown;
  // A force in the pipe counts: what acts then is what was ordered.
  const bool good = needed_n(acting, *margin_) <= order_.force_n || *margin_ >= settings_.target_margin;
  return good ? Event::margin_good : Event::margin_low;
}

void Law::take(Event event, std::int64_t now_ns) {
  const State next = next_state(state_, event);
  if (next == state_) return;
  // What an unknown force is followed by must not be less: without a ramp.
  if (!force_known_ && next == State::firm) force_n_ = settings_.firm_n;
  state_ = next;
  event_ = event;
  if (next == State::closing) closing_since_ns_ = now_ns;
}

double Law::wanted_n(const Reading& reading, double acting, double passed_s) const {
  if (state_ == State::closing || state_ == State::missed) return settings_.close_n;
  double wanted = force_n_;
  if (margin_) {
    const double needed = needed_n(acting, *margin_);
    if (needed > wanted) wanted = needed;
    const bool may_fall = state_ == State::holding && settled_s_ >= settings_.settle_s;
    if (may_fall && needed * (1 + settings_.spare) < wanted)
      wanted = std::max(needed, wanted * std::exp(-settings_.lower_per_s * passed_s));
  }
  if (state_ == State::reacting) {
    wanted = std::max(wanted, acting * settings_.slip_factor);
    if (std::isfinite(reading.increase_n))
      wanted = std::max(wanted, acting + reading.increase_n / settings_.fingers);
  }
  if (state_ == State::firm || state_ == State::cut_off || (state_ == State::reacting && !margin_))
    wanted = std::max(wanted, firm_n(reading, acting));
  wanted = std::clamp(wanted, settings_.least_n, settings_.most_n);
  return std::min(wanted, force_n_ + settings_.raise_n_per_s * passed_s);
}

double Law::needed_n(double acting, double margin) const {
  return std::max(settings_.least_n, acting * (1 - margin) / (1 - settings_.target_margin));
}

// What holds without a margin: by the least friction that is likely, or by the settings.
double Law::firm_n(const Reading& reading, double acting) const {
  if (!settings_.firm_by_low || !reading.bounded || state_ != State::firm) return settings_.firm_n;
  return std::min(settings_.firm_n, needed_n(acting, std::clamp(reading.gamma_low, 0.0, 1.0)));
}

// The margin that counts, at the end of the delay and of ahead_s, if it falls as forecast or the load grows
// on. Below 0 the object would slip by then: so much more force will be needed.
double Law::foreseen_margin(const Reading& reading) const {
  const double lead_s = settings_.delay_s + settings_.ahead_s;
  const double margin = sure_margin(reading), by_load = 1 - (1 - margin) * trend_.growth(lead_s);
  if (!(reading.time_to_slip_s >= 0)) return by_load;
  return std::min(by_load, margin * std::max(0.0, 1 - lead_s / std::max(reading.time_to_slip_s, 1e-6)));
}

// What friction surely holds, also where it is still a range, or may have fallen unseen. A margin that only
// is likely would let go.
double Law::sure_margin(const Reading& reading) {
  const double sigma = std::isfinite(reading.sigma) ? reading.sigma : 0;
  const double by_sigma = reading.gamma - sigma;
  return std::clamp(reading.bounded ? std::min(reading.gamma_low, by_sigma) : by_sigma, 0.0, 1.0);
}

// What was ordered the gripper's delay ago.
double Law::acting_n(std::int64_t now_ns) {
  const auto until = now_ns - static_cast<std::int64_t>(settings_.delay_s * kNsPerSecond);
  while (past_.size() > 1 && past_[1].time_ns <= until) past_.pop_front();
  return past_.empty() ? 0 : past_.front().force_n;
}

double Law::rounded(double force_n) const {
  if (!(settings_.resolution_n > 0)) return force_n;
  constexpr double kSameStep = 1e-6;  // of a step
  const double up = std::ceil(force_n / settings_.resolution_n - kSameStep) * settings_.resolution_n;
  const double highest =
      std::floor(settings_.most_n / settings_.resolution_n + kSameStep) * settings_.resolution_n;
  return std::min(up, highest);
}

void Law::watch_deafness(const Reading& reading, double acting, double passed_s) {
  const bool follows = !reading.known || !is_gripping(state_) || acting < kDeafFromN ||
                       reading.normal_n / settings_.fingers > acting / 2;
  deaf_s_ = follows ? 0 : deaf_s_ + passed_s;
}

}  // namespace slipd::grip
