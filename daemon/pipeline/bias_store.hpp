// Keeps sensors' zeros on disk and answers for them, in a thread of its own that there is only once a sensor
// needs it: the acquire thread must not wait for a disk, and io not for long.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "daemon/board/board.hpp"
#include "daemon/pipeline/bias_worker.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {

class BiasStore {
 public:
  // `log`: its own. All outlive it.
  BiasStore(LogRing& log, Wake& io) : log_(log), io_(io) {}
  ~BiasStore();
  BiasStore(const BiasStore&) = delete;
  BiasStore& operator=(const BiasStore&) = delete;

  // Acquire thread, while setting up: a desk for a sensor whose device has been opened, with the zero that is
  // kept for it, if there is a good one; why there is none is logged to `log` and told in the sensor's facts.
  std::shared_ptr<BiasWorker> attend(SensorStatus& status, const SensorInfo& sensor,
                                     const BiasIdentity& identity, LogRing& log);

  // Acquire thread, while setting up: this desk is not used any more.
  void leave(const std::shared_ptr<BiasWorker>& worker);

  // io, when the acquire threads have ended: keeps what is left, and ends.
  void ask_to_stop();
  bool join_until(std::chrono::steady_clock::time_point deadline) { return thread_.join_until(deadline); }

 private:
  void run();
  void look_at(BiasWorker& worker);
  void keep(BiasWorker& worker, const Bias& zero);
  std::vector<std::shared_ptr<BiasWorker>> workers() const;

  LogRing& log_;
  Wake& io_;
  Doorbell bell_;
  std::atomic<bool> stop_{false};  // relaxed: the bell orders it
  mutable std::mutex mutex_;       // guards the next two
  std::vector<std::shared_ptr<BiasWorker>> workers_;
  bool running_ = false;
  Thread thread_;
};

}  // namespace slipd
