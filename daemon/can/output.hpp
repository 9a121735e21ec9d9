// The CAN thread: runs a CanScheduler on a socket, woken by its deadlines and by changed alerts.
#pragma once

#include <atomic>

#include "daemon/can/scheduler.hpp"
#include "daemon/can/socket_port.hpp"
#include "daemon/rt/doorbell.hpp"
#include "daemon/rt/realtime.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd::can {

// Thread-safe between io and the CAN thread. Called from one thread: io, unless a function says otherwise.
class Output {
 public:
  // `bell`: rung by estimate when an alert or state may have changed. `settings.can` is set. All outlive it.
  Output(const Settings& settings, Board& board, Doorbell& bell);

  // Starts the thread. Once.
  void start(const RealtimeGrant& grant);

  // Sends the final messages and ends the thread. False: it still runs at `deadline`.
  bool stop(std::chrono::steady_clock::time_point deadline);

  // The present state. Read from any thread.
  const Latest<Report>& report() const noexcept { return scheduler_.report(); }

 private:
  void run() noexcept;

  const Settings& settings_;
  Doorbell& bell_;
  SocketPort port_;
  CanScheduler scheduler_;
  std::atomic<bool> stop_{false};  // relaxed: bell_ orders it
  Thread thread_;
};

}  // namespace slipd::can
