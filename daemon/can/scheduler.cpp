#include "daemon/can/scheduler.hpp"

#include <linux/can/error.h>

#include <algorithm>
#include <cerrno>

#include "drivers/can/can_interface.hpp"

namespace slipd::can {
namespace {

using namespace std::chrono_literals;

// Time between two messages of a standing alert; docs/can.md states it to receivers.
constexpr auto kAlertInterval = 50ms;
// Time between two heartbeats; docs/can.md states it to receivers.
constexpr auto kHeartbeatInterval = 1s;
// Time until the next attempt after a full queue. Longer: an alert is later. Shorter: more failed calls.
constexpr auto kRetryInterval = 1ms;
// The same after the interface was down.
constexpr auto kDownInterval = 20ms;
// The same after the interface was gone; each attempt opens a socket.
constexpr auto kReopenInterval = 200ms;
// How long nothing is sent for a device that has not been opened yet; then its fault is.
constexpr auto kOpeningTimeout = 3s;

std::int64_t nanoseconds_of(CanScheduler::Time time) noexcept {
  return std::chrono::nanoseconds(time.time_since_epoch()).count();
}

// Moves `next` by whole intervals beyond `now`: a late thread skips periods and keeps their phase.
void advance(CanScheduler::Time& next, std::chrono::nanoseconds interval, CanScheduler::Time now) noexcept {
  if (next <= now) next += ((now - next) / interval + 1) * interval;
}

}  // namespace

CanScheduler::CanScheduler(const Settings& settings, const Board& board, Port& port, LogRing& log, Time start)
    : can_(*settings.can),
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
  poll_bus_errors();
  update_views(now);
  mark_due(now);
  if (ensure_open(now) && now >= retry_) {
    const bool all =
        send_alerts(now) && send_estimates(now) && send_sliding(now) && send_heartbeat(now, false);
    if (!all) retry_ = now + (up_ ? kRetryInterval : kDownInterval);
  }
  publish();
  Time until = std::min(next_period_, next_heartbeat_ > now ? next_heartbeat_ : now + kReopenInterval);
  for (const MessageSlot& slot : slots_) {
    if (is_raised(slot.view.estimate.alert) && slot.alert_due > now) until = std::min(until, slot.alert_due);
  }
  return retry_ > now ? std::min(until, retry_) : until;
}

void CanScheduler::send_final(Time now) noexcept {
  update_views(now);
  if (!ensure_open(now)) return;
  for (MessageSlot& slot : slots_) {
    Estimate stale;
    stale.sequence = slot.view.estimate.sequence;
    stale.alert = without_frames(slot.view.estimate.alert);
    stale.alert_cause = slot.view.estimate.alert_cause;
    slot.view.estimate = stale;
    slot.due = true;
    slot.sliding_due = can_.sliding;
    ++slot.estimate_counter;
    slot.alert_due = now;
  }
  next_heartbeat_ = now;
  // The heartbeat first: it alone says that no estimate holds any more.
  static_cast<void>(send_heartbeat(now, true) && send_estimates(now) && send_alerts(now) &&
                    send_sliding(now));
  publish();
}

void CanScheduler::poll_bus_errors() noexcept {
  BusError error;
  while (open_ && port_.next_error(error)) handle_bus_error(error);
}

void CanScheduler::handle_bus_error(const BusError& error) noexcept {
  ++report_data_.bus_errors;
  if ((error.kind & CAN_ERR_CRTL) != 0) {
    constexpr unsigned kByte = 1;
    const unsigned state = error.data[kByte];
    if ((state & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) controller_ = Bus::warning;
    if ((state & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) controller_ = Bus::passive;
    if ((state & CAN_ERR_CRTL_ACTIVE) != 0) controller_ = Bus::up;
  }
  if ((error.kind & CAN_ERR_BUSOFF) != 0) {
    controller_ = Bus::bus_off;
    ++report_data_.bus_offs;
  }
  if ((error.kind & CAN_ERR_RESTARTED) != 0) controller_ = Bus::up;
}

bool CanScheduler::ensure_open(Time now) noexcept {
  if (open_) return true;
  if (now < reopen_) return false;
  report_data_.error = port_.open();
  if (report_data_.error != 0) {
    reopen_ = now + kReopenInterval;
    return false;
  }
  if (was_open_) ++report_data_.reopened;
  open_ = up_ = was_open_ = true;
  controller_ = Bus::up;
  return true;
}

void CanScheduler::update_views(Time now) noexcept {
  const std::int64_t now_ns = nanoseconds_of(now);
  report_data_.withheld = 0;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    slots_[i].view = slots_[i].source.view_at(now_ns);
    if (slots_[i].view.simulated && !can_.allow_simulated) report_data_.withheld |= std::uint32_t{1} << i;
  }
}

bool CanScheduler::withheld(std::size_t index, Time now) noexcept {
  const bool unknown = slots_[index].view.opening && now - start_ < kOpeningTimeout;
  return unknown || (report_data_.withheld >> index & 1U) != 0;
}

void CanScheduler::mark_due(Time now) noexcept {
  if (now < next_period_) return;
  advance(next_period_, can_.period, now);
  for (MessageSlot& slot : slots_) {
    slot.due = true;
    slot.sliding_due = can_.sliding;
    ++slot.estimate_counter;  // even if it cannot be sent: receivers see the jump
  }
}

bool CanScheduler::send_alerts(Time now) noexcept {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    MessageSlot& slot = slots_[i];
    const Estimate& estimate = slot.view.estimate;
    const bool raised = is_raised(estimate.alert);
    // From none to unknown and back is told by the estimates.
    const bool changed =
        estimate.alert != slot.last_sent_alert && (raised || is_raised(slot.last_sent_alert));
    const bool repeated = raised && now >= slot.alert_due;
    if ((!changed && !repeated) || withheld(i, now)) continue;
    const std::uint32_t id = can_.base_id + kAlertOffset + static_cast<std::uint32_t>(i);
    if (send(encode_alert(id, estimate, slot.view.simulated, slot.alert_counter), now) != Outcome::sent)
      return false;
    ++slot.alert_counter;
    slot.last_sent_alert = estimate.alert;
    slot.alert_due = now + kAlertInterval;
  }
  return true;
}

bool CanScheduler::send_estimates(Time now) noexcept {
  for (std::size_t turn = 0; turn < slots_.size(); ++turn) {
    const std::size_t i = first_slot_;
    MessageSlot& slot = slots_[i];
    if (slot.due && !withheld(i, now)) {
      const std::uint32_t id = can_.base_id + static_cast<std::uint32_t>(i);
      const Message message =
          encode_estimate(id, slot.view.estimate, slot.view.simulated, slot.estimate_counter);
      if (send(message, now) != Outcome::sent) return false;
    }
    slot.due = false;
    first_slot_ = (first_slot_ + 1) % slots_.size();
  }
  return true;
}

// Beside the estimates of the same period, with their counter.
bool CanScheduler::send_sliding(Time now) noexcept {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    MessageSlot& slot = slots_[i];
    if (slot.sliding_due && !withheld(i, now)) {
      const std::uint32_t id = can_.base_id + kSlidingOffset + static_cast<std::uint32_t>(i);
      if (send(encode_sliding(id, slot.view.estimate, slot.view.simulated, slot.estimate_counter), now) !=
          Outcome::sent)
        return false;
    }
    slot.sliding_due = false;
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
  advance(next_heartbeat_, kHeartbeatInterval, now);
  return true;
}

CanScheduler::Outcome CanScheduler::send(const Message& message, Time now) noexcept {
  const int error = port_.send(message);
  if (error == 0) {
    ++report_data_.sent;
    if (!up_) controller_ = Bus::up;  // the controller was restarted
    up_ = true;
    return Outcome::sent;
  }
  if (error == ENOBUFS || error == EAGAIN || error == EWOULDBLOCK) {
    ++report_data_.full;
    return Outcome::full;
  }
  ++report_data_.failed;
  handle_send_error(error, now);
  return Outcome::failed;
}

void CanScheduler::handle_send_error(int error, Time now) noexcept {
  up_ = false;
  if (error == ENETDOWN) return;  // the socket stays usable until it is up again
  report_data_.error = error;
  port_.close();
  open_ = false;
  reopen_ = now;
}

Bus CanScheduler::bus() const noexcept {
  if (!open_) return Bus::absent;
  return up_ ? controller_ : Bus::down;
}

void CanScheduler::publish() noexcept {
  report_data_.bus = bus();
  report_.store(report_data_);
  if (report_data_.bus == last_logged_bus_) return;
  last_logged_bus_ = report_data_.bus;
  const char* const interface = can_.interface.c_str();
  switch (report_data_.bus) {
    case Bus::absent:
      return log_.write(LogLevel::warning, {{}, Cause::bus}, "CAN: %s cannot be used: %s; tried again",
                        interface, why_no_can(report_data_.error));
    case Bus::down:
      return log_.write(LogLevel::warning, {{}, Cause::bus}, "CAN: %s is down", interface);
    case Bus::up:
      return log_.write(LogLevel::info, {{}, Cause::bus}, "CAN: %s is up", interface);
    default:
      return log_.write(LogLevel::warning, {{}, Cause::bus}, "CAN: %s is in state %s", interface,
                        to_string(report_data_.bus).data());
  }
}

}  // namespace slipd::can
