// Decides what is sent on the bus and when: an estimate of each source every period and, if configured,
// whether its object slides, alerts at once, a heartbeat every second. Handles an interface that is down,
// full or gone. A message that found no room is encoded anew later, so that the newest value is sent.
//
// It has no thread: step() does all that is due at a given time, so that tests need neither a clock nor a
// bus. After construction nothing allocates, locks, throws or blocks.
#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "config/settings.hpp"
#include "daemon/board/board.hpp"
#include "daemon/can/port.hpp"
#include "daemon/can/report.hpp"
#include "daemon/can/source.hpp"

namespace slipd::can {

// Not thread-safe, except report(). Called from one thread: can.
class CanScheduler {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Called from one thread: io. `settings.can` is set. `start`: the time of the first messages. All
  // references outlive it.
  CanScheduler(const Settings& settings, const Board& board, Port& port, LogRing& log, Time start);

  // Sends what is due at `now`. Returns when to call it next; to be called earlier if an alert may have
  // changed.
  Time step(Time now) noexcept;

  // Sends the final messages: every estimate stale, and a heartbeat that says stopping. Each is tried once.
  void send_final(Time now) noexcept;

  // The present state. Read from any thread.
  const Latest<Report>& report() const noexcept { return report_; }

 private:
  enum class Outcome : std::uint8_t { sent, full, failed };
  struct MessageSlot {
    CanSource source;
    unsigned estimate_counter = 0, alert_counter = 0;  // of the messages
    bool due = false;                                  // this period's estimate was not sent yet
    bool sliding_due = false;                          // nor was this period's message of sliding
    Alert last_sent_alert = Alert::none;               // the alert last sent
    Time alert_due{};                                  // when it is sent again
    CanSource::View view;
  };

  void poll_bus_errors() noexcept;
  void handle_bus_error(const BusError& error) noexcept;
  bool ensure_open(Time now) noexcept;
  void update_views(Time now) noexcept;
  bool withheld(std::size_t index, Time now) noexcept;
  void mark_due(Time now) noexcept;
  bool send_alerts(Time now) noexcept;
  bool send_estimates(Time now) noexcept;
  bool send_sliding(Time now) noexcept;
  bool send_heartbeat(Time now, bool stopping) noexcept;
  Outcome send(const Message& message, Time now) noexcept;
  void handle_send_error(int error, Time now) noexcept;
  void publish() noexcept;
  Bus bus() const noexcept;

  const CanSettings& can_;
  Port& port_;
  LogRing& log_;
  const Time start_;
  std::vector<MessageSlot> slots_;
  std::size_t first_slot_ = 0;  // source whose estimate is sent first: rotates, so that a full queue does not
                                // always delay the same one
  unsigned heartbeats_ = 0;
  Time next_period_, next_heartbeat_, retry_;
  Time reopen_;
  bool open_ = false, up_ = false, was_open_ = false;
  Bus controller_ = Bus::up;
  Bus last_logged_bus_ = Bus::up;
  Report report_data_;
  Latest<Report> report_;
};

}  // namespace slipd::can
