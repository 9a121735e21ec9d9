// What goes on the bus and when: estimates each period, alerts at once, the heartbeat; and what to do about a
// bus that does not take them. The newest value wins: a message that found no room is made anew when there is
// some.
//
// Not a thread: step() does all that is due at a given time, so that tests need neither a clock nor a bus.
// Nothing allocates, locks, throws or blocks once it is made.
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

class CanScheduler {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // `settings` has a section can. All outlive it.
  CanScheduler(const Settings& settings, const Board& board, Port& port, LogRing& log, Time start);

  // Sends what is due; returns when something will be. To be called then, and whenever an alert may have
  // changed.
  Time step(Time now) noexcept;

  // The last words: every margin stale, and that slipd stops. As far as there is room; nothing is tried
  // again.
  void end(Time now) noexcept;

  const Latest<Report>& report() const noexcept { return report_; }

 private:
  enum class Outcome : std::uint8_t { sent, full, failed };
  struct MessageSlot {
    CanSource source;
    unsigned estimates = 0, alerts = 0;  // turns, for the counters
    bool due = false;                    // this period's estimate is still to be sent
    Alert said = Alert::none;            // the level last sent
    Time alert_again{};                  // when it is to be repeated, or tried again
    CanSource::View view;
  };

  void listen() noexcept;
  void hear(const BusError& error) noexcept;
  bool be_open(Time now) noexcept;
  void look(Time now) noexcept;
  bool withheld(std::size_t index, Time now) noexcept;
  void mark_due(Time now) noexcept;
  bool send_alerts(Time now) noexcept;
  bool send_estimates(Time now) noexcept;
  bool send_heartbeat(Time now, bool stopping) noexcept;
  Outcome send(const Message& message, Time now) noexcept;
  void lost(int error, Time now) noexcept;
  void publish() noexcept;
  Bus bus() const noexcept;

  const Settings& settings_;
  const CanSettings& can_;
  Port& port_;
  LogRing& log_;
  const Time start_;
  std::vector<MessageSlot> slots_;
  std::size_t next_ = 0;  // who is to speak first, so that a full queue does not always hit the same
  unsigned heartbeats_ = 0;
  Time next_period_, next_heartbeat_, retry_;
  Time reopen_;
  bool open_ = false, up_ = false, was_open_ = false;
  Bus controller_ = Bus::up;
  Bus told_ = Bus::up;
  Report now_;
  Latest<Report> report_;
};

}  // namespace slipd::can
