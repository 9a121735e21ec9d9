// What the methods on the socket may look at. Made by the service, read by io.
#pragma once

#include <chrono>
#include <functional>
#include <vector>

#include "config/settings.hpp"
#include "daemon/board/board.hpp"
#include "daemon/can/report.hpp"
#include "daemon/rt/realtime.hpp"
#include "daemon/telemetry/latency_window.hpp"

namespace slipd {

class FlightRecorder;

struct ServiceContext {
  const Settings& settings;
  Board& board;
  RealtimeGrant realtime;
  std::function<void()> ring_estimate;  // after a request for the estimate thread was left on the board
  FlightRecorder* flight = nullptr;     // null: recorder.seconds is 0
  std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
  std::size_t clients = 0;
  std::uint64_t notifications_dropped = 0;  // for clients that were too slow, over all
  LatencyHistogram told{};  // published → all of it given to the kernel, over all subscribers
  LatencyWindow told_last_minute{};
  std::vector<LatencyWindow> last_minute;    // per sensor, of its latency
  std::vector<double> rates_hz;              // estimates a second, per sensor, over the last second or so
  const Latest<can::Report>* can = nullptr;  // null: no CAN output
};

}  // namespace slipd
