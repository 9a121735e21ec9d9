// Everything between the devices and the board: makes drivers, starts and stops threads.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "daemon/pipeline/acquirer.hpp"
#include "daemon/pipeline/estimate_loop.hpp"
#include "daemon/pipeline/estimator_factory.hpp"

namespace slipd {

// Called from one thread: io, unless a function says otherwise.
class Pipeline {
 public:
  // Makes a driver for each device. Sensors with the same driver and the same non-empty `device` share one.
  // Puts the sensors and grasps on the board. Touches no device. `output`: rung when an alert or state may
  // have changed; null: nobody waits. All references outlive it. Throws SettingsError with the problems of
  // all drivers.
  Pipeline(const Settings& settings, DriverCatalogue& drivers, Board& board, ModelSource models,
           Doorbell* output = nullptr);

  // Starts all threads. Once.
  void start(const RealtimeGrant& grant);

  // Before start; see EstimatorFactory.
  void adopt_learned_state(std::vector<LearnedState> learned) {
    estimator_factory_.adopt_learned_state(std::move(learned));
  }
  // After stop returned true; see EstimatorFactory.
  std::vector<LearnedState> release_learned_state() { return estimator_factory_.release_learned_state(); }

  // Stops and joins all threads, by about `deadline`. False: a driver hangs in its thread. Then nothing that
  // it may use can be destroyed, and the process can end only by _exit.
  bool stop(std::chrono::steady_clock::time_point deadline);
  // What had not ended when stop() returned, for people: "the driver of left"; empty: all had.
  const std::string& unfinished() const noexcept { return unfinished_; }

  // Called from any thread. Increases at least four times a second while the estimate thread runs.
  std::uint64_t heartbeat() const noexcept { return estimate_loop_.heartbeat(); }

  // Called from any thread, after a request for the estimate thread was written to the board. Wakes it.
  void ring() noexcept { bell_.ring(); }

 private:
  const Settings& settings_;
  Doorbell bell_;
  std::vector<std::unique_ptr<SensorRuntime>> runtimes_;
  EstimatorFactory estimator_factory_;
  EstimateLoop estimate_loop_;
  std::vector<std::unique_ptr<Acquirer>> acquirers_;
  BiasStore bias_store_;                    // declared last of these: destroyed before the sensors it uses
  std::atomic<bool> stop_estimate_{false};  // relaxed: bell_ orders it
  Thread estimate_thread_;
  std::string unfinished_;
};

}  // namespace slipd
