// What telemetry and RPC methods see of the running service. Made by Engine; used by io only.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "config/settings.hpp"
#include "daemon/board/board.hpp"
#include "daemon/can/report.hpp"
#include "daemon/rt/realtime.hpp"
#include "daemon/telemetry/latency_window.hpp"

namespace slipd {

class FlightRecorder;

// Recordings that clients asked for with `record`, since the start.
struct RecordingCounts {
  // Those that were written to their end.
  std::uint64_t written = 0;
  // Those that were not.
  std::uint64_t failed = 0;
};

// Not thread-safe. Used by one thread: io.
struct ServiceContext {
  // The configuration in use.
  const Settings& settings;
  // The board in use.
  Board& board;
  // What real-time privileges the system granted.
  RealtimeGrant realtime;
  // Wakes the estimate thread after a request for it was written to the board.
  std::function<void()> ring_estimate;
  // The flight recorder; null: off.
  FlightRecorder* flight = nullptr;
  // When slipd started; kept over a reload.
  std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
  // Clients connected.
  std::size_t clients = 0;
  // Bytes of answers that clients have requested and not read yet. Never null.
  std::function<std::size_t()> owed_bytes = [] { return std::size_t{0}; };
  // How often a client was not read from any more because it did not read its answers.
  std::uint64_t clients_held_back = 0;
  // Requests refused because clients are owed too much.
  std::uint64_t requests_refused = 0;
  // Notifications dropped because a client was too slow, over all clients.
  std::uint64_t notifications_dropped = 0;
  // Recordings that clients asked for; kept over a reload. Shared, because a recording may end after it.
  std::shared_ptr<RecordingCounts> recordings = std::make_shared<RecordingCounts>();
  // From an estimate's publication until its notification was handed to the kernel, over all subscribers.
  LatencyHistogram delivery_latency{};
  // The same over the last minute.
  LatencyWindow delivery_latency_last_minute{};
  // For each sensor, SensorStatus::latency over the last minute.
  std::vector<LatencyWindow> latency_last_minute;
  // For each sensor, estimates a second over the last second.
  std::vector<double> rates_hz;
  // For each sensor, how many of them repeated the frame before.
  std::vector<double> repeats_hz;
  // State of the CAN output; null: there is none.
  const Latest<can::Report>* can = nullptr;
};

}  // namespace slipd
