// Everything between the devices and the board: makes drivers, starts and stops threads.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "daemon/pipeline/acquirer.hpp"
#include "daemon/pipeline/estimate_threads.hpp"
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
  // After stop; see EstimatorFactory. Nothing if a thread that uses it has not ended.
  std::vector<LearnedState> release_learned_state();

  // Stops and joins all threads, by about `deadline`. False: a driver hangs in its thread. Then nothing that
  // it may use can be destroyed, and the process can end only by _exit.
  bool stop(std::chrono::steady_clock::time_point deadline);
  // What had not ended when stop() returned, for people: "the driver of left"; empty: all had.
  const std::string& unfinished() const noexcept { return unfinished_; }

  // Whether each estimate thread has run since the last call, which was at least a quarter of a second ago.
  bool all_ran() noexcept { return estimate_threads_.all_ran(); }

  // Called from any thread, after a request for estimate threads was written to the board. Wakes them.
  void ring() noexcept { estimate_threads_.ring(); }

 private:
  const Settings& settings_;
  std::vector<std::unique_ptr<SensorRuntime>> runtimes_;
  EstimateThreads estimate_threads_;
  EstimatorFactory estimator_factory_;
  std::vector<std::unique_ptr<Acquirer>> acquirers_;
  BiasStore bias_store_;  // declared last of these: destroyed before the sensors it uses
  std::string unfinished_;
  bool learning_ended_ = false;  // no thread uses estimators any more
};

}  // namespace slipd
