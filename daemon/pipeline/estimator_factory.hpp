// The set-up thread: makes an estimator for each sensor whose device was opened. Loading or training a model
// takes long, so it happens here and blocks no other thread. Normal scheduling; may allocate, lock and wait.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/estimate_threads.hpp"
#include "daemon/pipeline/sensor_runtime.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {

// The trained model for a chain that needs one. Called from one thread: set-up. May take minutes. Throws
// std::exception if there is none, and soon after a stop was requested.
using ModelSource =
    std::function<std::shared_ptr<const TrainedModel>(const std::string& sensor, const ChainSetup& setup)>;

// Why the chain does not use the configured method, for people; empty where it does.
std::string why_method_is_replaced(const ChainSetup& setup);

// Thread-safe; each function names its callers.
class EstimatorFactory {
 public:
  // `estimate`: told when an estimator is ready. All references outlive it.
  EstimatorFactory(const Settings& settings, std::vector<std::unique_ptr<SensorRuntime>>& runtimes,
                   LogRing& log, EstimateThreads& estimate, ModelSource models);
  ~EstimatorFactory();

  // Called from one thread: io. Starts the thread. Once.
  void start();
  // Called from one thread: io. The thread ends after the estimator that it is making.
  void request_stop();
  // Called from one thread: io. See Thread::join_until.
  bool join_until(std::chrono::steady_clock::time_point deadline) { return thread_.join_until(deadline); }

  // Called from one thread: io, before start. Learned states of the previous configuration. A sensor with the
  // same settings and set-up continues with its own.
  void adopt_learned_state(std::vector<LearnedState> learned) { learned_ = std::move(learned); }
  // Called from one thread: io, after this thread and the estimate thread ended. The learned state of each
  // sensor, with those that were adopted but not used.
  std::vector<LearnedState> release_learned_state();

  // Called from any thread but real-time ones. Requests an estimator for this feed.
  void request(std::size_t sensor, std::shared_ptr<FrameFeed> feed);

 private:
  struct Job {
    std::size_t sensor = 0;
    std::shared_ptr<FrameFeed> feed;
  };
  void run();
  void make(const Job& job);
  // Throws std::exception if there is no estimator for this sensor.
  const EstimatorInstance& build(const Job& job, SensorRuntime& runtime);
  std::optional<EstimatorChain> take_learned_state(const SensorRuntime& runtime, const ChainSetup& setup);
  void free_retired();

  const Settings& settings_;
  std::vector<std::unique_ptr<SensorRuntime>>& runtimes_;
  LogRing& log_;
  EstimateThreads& estimate_;
  ModelSource models_;
  // All that were made and not yet freed. Used by the set-up thread, later by the destructor.
  std::vector<std::unique_ptr<EstimatorInstance>> instances_;
  std::vector<LearnedState> learned_;  // used by the set-up thread once it runs
  std::mutex mutex_;                   // guards the next two
  std::deque<Job> jobs_;
  bool stop_ = false;
  std::condition_variable changed_;
  Thread thread_;
};

}  // namespace slipd
