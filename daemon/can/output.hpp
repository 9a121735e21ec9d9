// The CAN thread: a CanScheduler on a socket, woken by the clock or by a change of alert. io makes, starts
// and stops it.
#pragma once

#include <atomic>

#include "daemon/can/scheduler.hpp"
#include "daemon/can/socket_port.hpp"
#include "daemon/rt/doorbell.hpp"
#include "daemon/rt/realtime.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd::can {

class Output {
 public:
  // `bell` rings when an alert may have changed. `settings` has a section can; all outlive it.
  Output(const Settings& settings, Board& board, Doorbell& bell);

  void start(const RealtimeGrant& grant);

  // Ends it with its last words. False: it was not done by `deadline`.
  bool stop(std::chrono::steady_clock::time_point deadline);

  const Latest<Report>& report() const noexcept { return scheduler_.report(); }

 private:
  void run() noexcept;

  const Settings& settings_;
  Doorbell& bell_;
  SocketPort port_;
  CanScheduler scheduler_;
  std::atomic<bool> stop_{false};  // relaxed: the bell orders it
  Thread thread_;
};

}  // namespace slipd::can
