// The set-up thread: makes an estimator for every sensor whose device has been opened, so that neither a
// model being loaded nor one being trained holds up anybody. Normal scheduling; allocates, locks and waits as
// it likes.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/sensor_runtime.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {

// The trained model for a chain that needs one. Called by the set-up thread; may take minutes; throws
// std::exception for what cannot be had, and soon after a stop was asked for.
using ModelSource =
    std::function<std::shared_ptr<const Model>(const std::string& sensor, const ChainSetup& setup)>;

// Why the chain does not use the configured method, for people; empty where it does.
std::string why_method_is_replaced(const ChainSetup& setup);

class EstimatorFactory {
 public:
  EstimatorFactory(const Settings& settings, std::vector<std::unique_ptr<SensorRuntime>>& runtimes,
                   LogRing& log, Doorbell& estimate, ModelSource models);
  ~EstimatorFactory();

  void start();
  void ask_to_stop();
  bool join_until(std::chrono::steady_clock::time_point deadline) { return thread_.join_until(deadline); }

  // Before start: what sensors of the configuration before had learnt. One that is still configured as it was
  // goes on with it.
  void inherit(std::vector<LearnedState> learned) { inherited_ = std::move(learned); }
  // After the end of this thread and of the estimate thread.
  std::vector<LearnedState> give_up();

  // Any thread but the real-time ones: a lane is wanted for this feed.
  void want(std::size_t sensor, std::shared_ptr<FrameFeed> feed);

 private:
  struct Job {
    std::size_t sensor = 0;
    std::shared_ptr<FrameFeed> feed;
  };
  void run();
  void make(const Job& job);
  const EstimatorInstance& build(
      const Job& job, SensorRuntime& runtime);  // throws std::exception for an estimator that cannot be had
  std::optional<EstimatorChain> inherited(const SensorRuntime& runtime, const ChainSetup& setup);
  void free_retired();

  const Settings& settings_;
  std::vector<std::unique_ptr<SensorRuntime>>& runtimes_;
  LogRing& log_;
  Doorbell& estimate_;
  ModelSource models_;
  std::vector<std::unique_ptr<EstimatorInstance>>
      instances_;  // every one made and not yet freed; set-up thread, then the destructor
  std::vector<LearnedState> inherited_;  // set-up thread, once it runs
  std::mutex mutex_;                     // guards the next two
  std::deque<Job> jobs_;
  bool stop_ = false;
  std::condition_variable changed_;
  Thread thread_;
};

}  // namespace slipd
