// Saves sensors' biases to disk and completes requests for new ones, in a thread of its own, because neither
// acquire nor io may wait for the disk. The thread is started by the first sensor that needs it.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "daemon/board/board.hpp"
#include "daemon/pipeline/bias_worker.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {

// Thread-safe; each function names its callers.
class BiasStore {
 public:
  // `log`: written by the store's thread only. `io_wakeup`: notified when requests are complete. Both outlive
  // it.
  BiasStore(LogRing& log, IoWakeup& io_wakeup) : log_(log), io_wakeup_(io_wakeup) {}
  // Requests a stop and joins.
  ~BiasStore();
  BiasStore(const BiasStore&) = delete;
  BiasStore& operator=(const BiasStore&) = delete;

  // Called from acquire threads, out of real time. The worker of a sensor whose device was opened, with its
  // saved bias if there is one that can be used. If not, the reason is written to `log` and to the sensor's
  // facts. May wait for the disk.
  std::shared_ptr<BiasWorker> register_sensor(SensorStatus& status, const SensorInfo& sensor,
                                              const BiasIdentity& identity, LogRing& log);

  // Called from acquire threads, out of real time. `worker` is no longer used; its last bias may be unsaved.
  void unregister_sensor(const std::shared_ptr<BiasWorker>& worker);

  // Called from one thread: io, after the acquire threads ended. The thread saves what is pending and ends.
  void request_stop();
  // Called from one thread: io. See Thread::join_until.
  bool join_until(std::chrono::steady_clock::time_point deadline) { return thread_.join_until(deadline); }

 private:
  void run();
  void process(BiasWorker& worker);
  void report_doubt(BiasWorker& worker, const BiasReport& report);
  void save(BiasWorker& worker, const Bias& zero, const BiasReport& report);
  std::vector<std::shared_ptr<BiasWorker>> workers() const;

  LogRing& log_;
  IoWakeup& io_wakeup_;
  Doorbell bell_;
  std::atomic<bool> stop_{false};  // relaxed: bell_ orders it
  mutable std::mutex mutex_;       // guards the next two
  std::vector<std::shared_ptr<BiasWorker>> workers_;
  bool running_ = false;
  Thread thread_;
};

}  // namespace slipd
