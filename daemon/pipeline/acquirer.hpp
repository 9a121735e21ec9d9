// The acquire thread of one device: opens it, reads frames, and reopens it with back-off when it is lost. A
// driver that hangs blocks this thread only.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/bias_store.hpp"
#include "daemon/pipeline/estimate_threads.hpp"
#include "daemon/pipeline/sensor_runtime.hpp"
#include "daemon/rt/realtime.hpp"
#include "daemon/rt/thread.hpp"

namespace slipd {

// Called with a sensor's feed after its device was opened, so that an estimator is made for it. Called from
// acquire threads, out of real time.
using FeedOpened = std::function<void(std::size_t sensor, std::shared_ptr<FrameFeed> feed)>;

// Called from one thread: io, except for its own thread's body.
class Acquirer {
 public:
  // `sensors`: indices into `runtimes` of this device's sensors, in the driver's order. `bias_store`,
  // `runtimes`, `log` and `estimate` outlive it.
  Acquirer(std::unique_ptr<DeviceDriver> driver, const std::vector<std::size_t>& sensors,
           std::vector<std::unique_ptr<SensorRuntime>>& runtimes, BiasStore& bias_store, LogRing& log,
           EstimateThreads& estimate, FeedOpened opened);

  // Starts the thread. Once.
  void start(const RealtimeSettings& settings, const RealtimeGrant& grant);
  // Returns at once; the thread ends when the driver's read returns.
  void request_stop() noexcept;
  // The names of its sensors, for people.
  const std::string& sensors() const noexcept { return name_; }
  // Joins the thread; see Thread::join_until.
  bool join_until(std::chrono::steady_clock::time_point deadline) { return thread_.join_until(deadline); }

 private:
  struct SensorChannel {
    std::size_t sensor = 0;
    SensorRuntime* runtime = nullptr;
    EstimateLoop* estimate = nullptr;  // told of each frame
    std::shared_ptr<FrameFeed> feed;
    std::shared_ptr<BiasWorker> bias;  // null: the device subtracts its bias
    std::vector<float> gain;           // of each taxel; empty: all are 1
    ArrivalCounts arrivals;
    std::optional<std::uint64_t> last_sequence;  // none: no frame since it was opened
  };
  enum class ReadEnd : std::uint8_t {
    stopped,
    disconnected,
    ended,
    silent,   // the device is open and has completed no frame for a while; reading goes on
    changed,  // the device is not what it was when it was opened
    away,     // no program is connected that sends frames; reading goes on
    speaking  // the first frame after `silent` or `away`; reading goes on
  };

  void run();
  void open_and_read();
  bool open();
  DeviceInfo open_driver();
  void enter_driver(DriverWatch::Call call, Doorbell::Clock::duration allowed) noexcept;
  void leave_driver() noexcept;
  void connect_sensors(const DeviceInfo& info);
  void connect_bias(SensorChannel& channel, const DeviceInfo& info, const SensorInfo& sensor);
  ReadEnd read_in_realtime();
  ReadEnd read_until_closed() noexcept;
  void set_silence(ReadEnd how);
  void come_back() noexcept;
  bool deliver(std::size_t index) noexcept;
  void set_link(DeviceLink link) noexcept;
  std::int64_t interval_since_last_frame() noexcept;
  bool stopping() const noexcept { return stop_.load(std::memory_order_relaxed); }

  std::unique_ptr<DeviceDriver> driver_;
  std::vector<SensorChannel> channels_;
  std::vector<FrameSlot> slots_;
  BiasStore& bias_store_;
  LogRing& log_;
  FeedOpened opened_;
  std::string name_;                 // the sensors' names, for the log
  std::string last_logged_trouble_;  // logged once, not at each attempt
  bool was_open_ = false;
  bool delivered_ = false;  // a frame, since it was last opened
  bool silent_ = false;     // since the last frame, or since it was opened, it was told that none comes
  bool away_ = false;       // and the link is absent for it, although the device is open
  std::string silence_;     // the trouble that set_silence wrote; empty: none
  Doorbell::Clock::time_point opened_at_;
  Doorbell::Clock::time_point last_frame_at_;
  std::optional<Doorbell::Clock::time_point> entered_at_;  // of the call in DriverWatch; none: in no call
  std::int64_t interval_ns_ = 0;  // mean time between frames of the device; 0: not known
  RealtimeSettings realtime_;
  RealtimeGrant grant_;
  Doorbell stop_bell_;
  std::atomic<bool> stop_{false};  // relaxed: stop_bell_ orders it
  Thread thread_;
};

}  // namespace slipd
