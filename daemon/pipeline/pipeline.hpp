// All that runs between the devices and the board: drivers made, threads started and stopped. Called by io.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "daemon/pipeline/acquirer.hpp"
#include "daemon/pipeline/estimate_loop.hpp"
#include "daemon/pipeline/estimator_factory.hpp"

namespace slipd {

class Pipeline {
 public:
  // Groups the sensors by device (equal driver and equal device, if that says anything) and makes their
  // drivers. Throws SettingsError with all that the drivers refuse. `output`, if any, is rung when an alert
  // may have changed. All outlive it.
  Pipeline(const Settings& settings, DriverCatalogue& drivers, Board& board, ModelSource models,
           Doorbell* output = nullptr);

  void start(const RealtimeGrant& grant);

  // Before start: see EstimatorFactory.
  void inherit(std::vector<LearnedState> learned) { maker_.inherit(std::move(learned)); }
  // After a stop that was true.
  std::vector<LearnedState> give_up() { return maker_.give_up(); }

  // Ends every thread, by `deadline`. False: a driver still hangs in its thread; nothing that it may touch
  // must be destroyed any more, so the process can only _exit.
  bool stop(std::chrono::steady_clock::time_point deadline);

  std::uint64_t heartbeat() const noexcept { return estimating_.heartbeat(); }

  // After a request was left on the board that concerns the estimate thread.
  void ring() noexcept { bell_.ring(); }

 private:
  const Settings& settings_;
  Doorbell bell_;
  std::vector<std::unique_ptr<SensorRuntime>> runtimes_;
  EstimatorFactory maker_;
  EstimateLoop estimating_;
  std::vector<std::unique_ptr<Acquirer>> acquirers_;
  BiasStore zeros_;                           // ends before what it looks at
  std::atomic<bool> stop_estimating_{false};  // relaxed: the bell orders it
  Thread estimate_thread_;
};

}  // namespace slipd
