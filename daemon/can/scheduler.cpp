#include "daemon/can/scheduler.hpp"

#include <linux/can/error.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace slipd::can {
namespace {

using namespace std::chrono_literals;

constexpr auto kAlertInterval = 50ms;
constexpr auto kHeartbeatInterval = 1s;
constexpr auto kRetryInterval = 1ms;     // of a full queue: what is sent then is as new as it can be
constexpr auto kDownInterval = 20ms;     // of an interface that is down
constexpr auto kReopenInterval = 200ms;  // of an interface that is gone
constexpr auto kOpeningPatience = 3s;    // until a device that was never opened is spoken of

std::int64_t nanoseconds_of(CanScheduler::Time time) noexcept {
  return std::chrono::nanoseconds(time.time_since_epoch()).count();
}

// The next multiple of the interval that is still to come: a late thread leaves turns out and keeps the beat.
void move_on(CanScheduler::Time& next, std::chrono::nanoseconds interval, CanScheduler::Time now) noexcept {
  if (next <= now) next += ((now - next) / interval + 1) * interval;
}

}  // namespace

CanScheduler::CanScheduler(const Settings& settings, const Board& board, Port& port, LogRing& log, Time start)
    : settings_(settings),
      can_(*settings.can),
      port_(port),
      log_(log),
      start_(start),
      next_period_(start),
      next_heartbeat_(start),
      retry_(start),
      reopen_(start) {
  for (CanSource& source : make_sources(board)) slots_.push_back({.source = std::move(source), .view = {}});
}

CanScheduler::Time CanScheduler::step(Time now) noexcept {
  listen();
  look(now);
  mark_due(now);
  if (be_open(now) && now >= retry_) {
    const bool all = send_alerts(now) && send_estimates(now) && send_heartbeat(now, false);
    if (!all) retry_ = now + (up_ ? kRetryInterval : kDownInterval);
  }
  publish();
  Time until = std::min(next_period_, next_heartbeat_ > now ? next_heartbeat_ : now + kReopenInterval);
  for (const MessageSlot& each : slots_) {
    if (each.view.estimate.alert != Alert::none && each.alert_again > now)
      until = std::min(until, each.alert_again);
  }
  return retry_ > now ? std::min(until, retry_) : until;
}

void CanScheduler::end(Time now) noexcept {
  look(now);
  if (!be_open(now)) return;
  for (MessageSlot& each : slots_) {
    Estimate stale;
    stale.sequence = each.view.estimate.sequence;
    stale.alert = each.view.estimate.alert;
    each.view.estimate = stale;
    each.due = true;
    ++each.estimates;
    each.alert_again = now;
  }
  next_heartbeat_ = now;
  // The heartbeat first: it is the shortest way of saying all of it.
  static_cast<void>(send_heartbeat(now, true) && send_estimates(now) && send_alerts(now));
  publish();
}

void CanScheduler::listen() noexcept {
  BusError error;
  while (open_ && port_.next_error(error)) hear(error);
}

void CanScheduler::hear(const BusError& error) noexcept {
  ++now_.bus_errors;
  if ((error.kind & CAN_ERR_CRTL) != 0) {
    constexpr unsigned kByte = 1;
    const unsigned state = error.data[kByte];
    if ((state & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) controller_ = Bus::warning;
    if ((state & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) controller_ = Bus::passive;
    if ((state & CAN_ERR_CRTL_ACTIVE) != 0) controller_ = Bus::up;
  }
  if ((error.kind & CAN_ERR_BUSOFF) != 0) {
    controller_ = Bus::bus_off;
    ++now_.bus_offs;
  }
  if ((error.kind & CAN_ERR_RESTARTED) != 0) controller_ = Bus::up;
}

bool CanScheduler::be_open(Time now) noexcept {
  if (open_) return true;
  if (now < reopen_) return false;
  now_.error = port_.open();
  if (now_.error != 0) {
    reopen_ = now + kReopenInterval;
    return false;
  }
  if (was_open_) ++now_.reopened;
  open_ = up_ = was_open_ = true;
  controller_ = Bus::up;
  return true;
}

void CanScheduler::look(Time now) noexcept {
  const std::int64_t now_ns = nanoseconds_of(now);
  now_.withheld = 0;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    slots_[i].view = slots_[i].source.look(now_ns);
    if (slots_[i].view.simulated && !can_.allow_simulated) now_.withheld |= std::uint32_t{1} << i;
  }
}

bool CanScheduler::withheld(std::size_t index, Time now) noexcept {
  const bool unknown = slots_[index].view.opening && now - start_ < kOpeningPatience;
  return unknown || (now_.withheld >> index & 1U) != 0;
}

void CanScheduler::mark_due(Time now) noexcept {
  if (now < next_period_) return;
  move_on(next_period_, can_.period, now);
  for (MessageSlot& each : slots_) {
    each.due = true;
    ++each.estimates;  // even if it cannot be sent: a jump tells of it
  }
}

bool CanScheduler::send_alerts(Time now) noexcept {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    MessageSlot& each = slots_[i];
    const Estimate& estimate = each.view.estimate;
    const bool changed = estimate.alert != each.said;
    const bool repeated = estimate.alert != Alert::none && now >= each.alert_again;
    if ((!changed && !repeated) || withheld(i, now)) continue;
    const std::uint32_t id = can_.base_id + kAlertOffset + static_cast<std::uint32_t>(i);
    if (send(encode_alert(id, estimate, each.view.simulated, each.alerts), now) != Outcome::sent)
      return false;
    ++each.alerts;
    each.said = estimate.alert;
    each.alert_again = now + kAlertInterval;
  }
  return true;
}

bool CanScheduler::send_estimates(Time now) noexcept {
  for (std::size_t turn = 0; turn < slots_.size(); ++turn) {
    const std::size_t i = next_;
    MessageSlot& each = slots_[i];
    if (each.due && !withheld(i, now)) {
      const std::uint32_t id = can_.base_id + static_cast<std::uint32_t>(i);
      const Message message = encode_estimate(id, each.view.estimate, each.view.simulated, each.estimates);
      if (send(message, now) != Outcome::sent) return false;
    }
    each.due = false;
    next_ = (next_ + 1) % slots_.size();
  }
  return true;
}

bool CanScheduler::send_heartbeat(Time now, bool stopping) noexcept {
  if (now < next_heartbeat_) return true;
  const auto uptime = std::chrono::duration_cast<std::chrono::seconds>(now - start_).count();
  const Heartbeat heartbeat{slots_.size(), static_cast<std::uint64_t>(uptime), stopping};
  if (send(encode_heartbeat(can_.base_id + kHeartbeatOffset, heartbeat, heartbeats_), now) != Outcome::sent)
    return false;
  ++heartbeats_;
  move_on(next_heartbeat_, kHeartbeatInterval, now);
  return true;
}

CanScheduler::Outcome CanScheduler::send(const Message& message, Time now) noexcept {
  const int error = port_.send(message);
  if (error == 0) {
    ++now_.sent;
    if (!up_) controller_ = Bus::up;  // it was started anew
    up_ = true;
    return Outcome::sent;
  }
  if (error == ENOBUFS || error == EAGAIN || error == EWOULDBLOCK) {
    ++now_.full;
    return Outcome::full;
  }
  ++now_.failed;
  lost(error, now);
  return Outcome::failed;
}

void CanScheduler::lost(int error, Time now) noexcept {
  up_ = false;
  if (error == ENETDOWN) return;  // the socket hears when it is up again
  now_.error = error;
  port_.close();
  open_ = false;
  reopen_ = now;
}

Bus CanScheduler::bus() const noexcept {
  if (!open_) return Bus::absent;
  return up_ ? controller_ : Bus::down;
}

void CanScheduler::publish() noexcept {
  now_.bus = bus();
  report_.store(now_);
  if (now_.bus == told_) return;
  told_ = now_.bus;
  const char* const interface = can_.interface.c_str();
  switch (now_.bus) {
    case Bus::absent:
      return log_.write(LogLevel::warning, {{}, Cause::bus}, "CAN: %s is not there (%s); looking for it",
                        interface,
                        now_.error == EMSGSIZE ? "set up without FD" : strerrordesc_np(now_.error));
    case Bus::down:
      return log_.write(LogLevel::warning, {{}, Cause::bus}, "CAN: %s is down", interface);
    case Bus::up:
      return log_.write(LogLevel::info, {{}, Cause::bus}, "CAN: %s is up", interface);
    default:
      return log_.write(LogLevel::warning, {{}, Cause::bus}, "CAN: %s is in state %s", interface,
                        to_string(now_.bus).data());
  }
}

}  // namespace slipd::can
