// One device: opened, read, and reopened with back-off for ever, in a thread of its own. A driver that hangs
// holds up this thread and nobody else's.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/bias_store.hpp"
#include "daemon/pipeline/sensor_runtime.hpp"
#include "daemon/rt/realtime.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {

// Asks for an estimator for a sensor whose device has just been opened. Called by the acquire thread while
// setting up.
using FeedOpened = std::function<void(std::size_t sensor, std::shared_ptr<FrameFeed> feed)>;

class Acquirer {
 public:
  // `sensors`: the indices of `seats` that this device carries, in the driver's order.
  Acquirer(std::unique_ptr<DeviceDriver> driver, const std::vector<std::size_t>& sensors,
           std::vector<std::unique_ptr<SensorRuntime>>& runtimes, BiasStore& zeros, LogRing& log,
           Doorbell& estimate, FeedOpened opened);

  void start(const RealtimeSettings& settings, const RealtimeGrant& grant);
  void ask_to_stop() noexcept;
  bool join_until(std::chrono::steady_clock::time_point deadline) { return thread_.join_until(deadline); }

 private:
  struct SensorChannel {
    std::size_t sensor = 0;
    SensorRuntime* runtime = nullptr;
    std::shared_ptr<FrameFeed> feed;
    std::shared_ptr<BiasWorker> zero;  // null: its frames are zeroed
    std::vector<float> gain;           // of each taxel; empty: 1
    Tally tally;
    std::optional<std::uint64_t> last_sequence;  // none: just (re)opened
  };
  enum class Ending : std::uint8_t { stopped, disconnected, ended };

  void run();
  void attend();
  bool open();
  void wire(const DeviceInfo& info);
  void wire_zero(SensorChannel& channel, const DeviceInfo& info, const SensorInfo& sensor);
  Ending pump() noexcept;
  bool deliver(std::size_t index) noexcept;
  void set_link(Link link) noexcept;
  bool stopping() const noexcept { return stop_.load(std::memory_order_relaxed); }

  std::unique_ptr<DeviceDriver> driver_;
  std::vector<SensorChannel> channels_;
  std::vector<FrameSlot> slots_;
  BiasStore& zeros_;
  LogRing& log_;
  Doorbell& estimate_;
  FeedOpened opened_;
  std::string name_;          // its sensors' names, for the log
  std::string last_trouble_;  // said once, not at each attempt
  bool was_open_ = false;
  bool delivered_ = false;  // a frame, since it was opened last
  RealtimeSettings realtime_;
  RealtimeGrant grant_;
  Doorbell stop_bell_;
  std::atomic<bool> stop_{false};  // relaxed: the bell orders it
  Thread thread_;
};

}  // namespace slipd
