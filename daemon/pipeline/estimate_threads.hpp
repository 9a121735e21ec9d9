// The estimate threads, and which sensors each has. One is enough for most; where their estimates may be more
// than one core can make, sensors are shared out, those of a grasp together, so that a grasp needs no lock.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/pipeline/estimate_loop.hpp"
#include "daemon/rt/realtime.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {

// Sensors 0 … sensors - 1 shared out to at most `threads` threads, in equal numbers as far as grasps, each a
// list of sensors that stay together, allow. Each part is in ascending order, and none is empty.
std::vector<std::vector<std::size_t>> share_out(std::size_t sensors,
                                                const std::vector<std::vector<std::size_t>>& grasps,
                                                std::size_t threads);

// How many threads estimate so many sensors: as configured, else one for each kSensorsOfThread, and no more
// than it has CPUs.
std::size_t estimate_threads(const RealtimeSettings& settings, std::size_t sensors);

// Called from one thread: io, unless a function says otherwise.
class EstimateThreads {
 public:
  // The board has all sensors and grasps. `output`: see EstimateLoop. All references outlive it.
  EstimateThreads(const RealtimeSettings& realtime, const AlertSettings& alerts, Board& board,
                  std::vector<std::unique_ptr<SensorRuntime>>& runtimes, Doorbell* output);

  // Starts all. Once.
  void start(const RealtimeGrant& grant);
  // Returns at once; each thread ends after its round, and retires its estimators.
  void request_stop() noexcept;
  // Joins all; see Thread::join_until.
  bool join_until(std::chrono::steady_clock::time_point deadline);

  // Called from any thread. The loop that estimates this sensor.
  EstimateLoop& of(std::size_t sensor) noexcept { return *loop_of_[sensor]; }
  // Called from any thread. What all threads have to look at has changed.
  void ring() noexcept;

  // Whether each thread has run since the last call, which was at least a quarter of a second ago.
  bool all_ran() noexcept;

 private:
  struct Running {
    std::unique_ptr<EstimateLoop> loop;
    Thread thread;
    std::uint64_t heartbeat = 0;  // at the last all_ran
  };
  const RealtimeSettings& realtime_;
  std::vector<Running> running_;
  std::vector<EstimateLoop*> loop_of_;  // of each sensor
  std::atomic<bool> stop_{false};       // relaxed: the loops' bells order it
};

}  // namespace slipd
