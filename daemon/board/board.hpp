// What threads share: a status for each sensor and grasp, a queue of events, log rings. The pipeline writes
// it; io, the CAN thread and the recorders read it. It is built before any thread starts, and its lists never
// change afterwards.
#pragma once

#include <array>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/estimate/estimate.hpp"
#include "core/frame/latest.hpp"
#include "core/frame/layout.hpp"
#include "core/grasp/finger_pose.hpp"
#include "core/health/health.hpp"
#include "core/reading/method/work_precision.hpp"
#include "daemon/board/bias_channel.hpp"
#include "daemon/board/driver_watch.hpp"
#include "daemon/board/frame_copy.hpp"
#include "daemon/board/latency.hpp"
#include "daemon/board/record_tap.hpp"
#include "daemon/board/shared_board.hpp"
#include "daemon/rt/io_wakeup.hpp"
#include "daemon/rt/log_ring.hpp"

namespace slipd {

// Frames of one sensor up to and with the one last estimated. Always received = estimated + skipped.
struct FrameCounts {
  std::uint64_t received = 0;   // delivered by the driver
  std::uint64_t estimated = 0;  // an estimate was published for them
  std::uint64_t skipped = 0;    // replaced by a newer one before they were estimated
  std::uint64_t gaps = 0;       // jumps of the device's sequence number
  std::uint64_t lost = 0;       // sequence numbers missing in those jumps
};

// What the estimate thread publishes for a sensor.
struct Published {
  Estimate estimate;
  FrameCounts counts;
};

// State of a sensor's device.
enum class DeviceLink : std::uint8_t {
  opening,  // the first attempt to open it has not ended
  open,     // frames are read
  absent,   // it could not be opened or was lost; it is tried again
  ended     // it was a recording, which is over
};

// What is known of a device once it is open. Written by acquire and set-up threads while they set up, and by
// the bias store; read by io and recorders. Guarded by a mutex; not used by real-time code.
struct DeviceFacts {
  // For people; empty until the device was opened.
  std::string description;
  // The device's serial number; empty: it has none.
  std::string serial;
  // What the sensor measures.
  SensorClass sensor_class = SensorClass::array3;
  // Where its taxels are; none until the device was opened.
  std::optional<TaxelLayout> layout;
  // Frames a second; 0: the device does not say.
  double rate_hz = 0;
  // The estimator's method; empty until there is an estimator.
  std::string method;
  // Why it is this one, as to_string(MethodReason); empty until there is an estimator.
  std::string method_reason;
  // Error against run time of the methods on this sensor's scene; without rows until it was measured.
  WorkPrecision tradeoff;
  // Time per frame within which `auto` chose, us; infinity: any.
  double budget_us = 0;
  // Why there is no device or no estimator, for people; empty: there is.
  std::string trouble;
  // Why there is no bias yet, or why it was not restored, not used or not saved, for people; empty: it was,
  // or slipd measures none.
  std::string zero_trouble;
};

// For people: why a sensor with a zero has the state unzeroed (core/patch/contact_gate.hpp).
inline constexpr const char* kZeroIsAnothers =
    "there is shear without pressure since the first frame: the zero is that of another sensor or of shifted "
    "counts; "
    "take off what touches it, then: slipctl rebias";

// Everything that threads share about one sensor. Thread-safe; each member names its writer.
class SensorStatus {
 public:
  SensorStatus(std::string sensor_name, std::string driver_name)
      : name(std::move(sensor_name)), driver(std::move(driver_name)) {}

  // As configured; unique.
  const std::string name;
  // The driver's name.
  const std::string driver;
  // Written by one thread: estimate; before that starts, by io.
  Latest<Published> latest;
  // From the sample to its published estimate. Written by one thread: estimate.
  LatencyHistogram latency;
  // Shared by io and the estimate thread.
  FrameCopy frame_copy;
  // Shared by io, the acquire thread and the bias store.
  BiasChannel bias;
  // Shared by the acquire thread and the flight recorder.
  RecordTap flight_tap;
  // Shared by the acquire thread and the writer of a client's recording.
  RecordTap record_tap;
  // Whether the device is a simulation. Written by one thread: acquire, while it opens the device. Relaxed:
  // no other memory is read because of this value.
  std::atomic<bool> simulated{false};
  // Without a frame for this long, ns, an estimate is stale. Written by one thread: estimate, when it learns
  // the device's rate. Relaxed: an independent value.
  std::atomic<std::int64_t> stale_after_ns{20'000'000};
  // Until then, ns of CLOCK_MONOTONIC, the robot lets go of the object, as a client has said. Written by one
  // thread: io. Relaxed: an independent value.
  std::atomic<std::int64_t> releasing_until_ns{0};
  // Written by one thread: acquire, with release. A reader with acquire (EstimateLoop::process,
  // can::CanSource::view_at) also sees the frames delivered before. Readers that only show it use relaxed.
  std::atomic<DeviceLink> link{DeviceLink::opening};
  // Whether the driver hangs. Written by one thread: acquire.
  DriverWatch driver_watch;
  // Packets or frames that the driver dropped. Written by one thread: acquire. Relaxed: a counter.
  std::atomic<std::uint64_t> corrupt{0};
  // Reads that returned without a frame. Written by one thread: acquire. Relaxed: a counter.
  std::atomic<std::uint64_t> timeouts{0};
  // Times that the device was opened again. Written by one thread: acquire. Relaxed: a counter.
  std::atomic<std::uint64_t> reconnects{0};
  // Frames of each health, by its number; frames of health good are not counted. Written by one thread:
  // estimate. Relaxed: counters.
  std::array<std::atomic<std::uint64_t>, kHealths> implausible{};
  // Frames that are the one before once more: no new measurement. Written by one thread: estimate. Relaxed: a
  // counter.
  std::atomic<std::uint64_t> repeated{0};
  // Events that did not fit into Board::events. Written by one thread: estimate. Relaxed: a counter.
  std::atomic<std::uint64_t> events_lost{0};

  // A copy of what is known of the device. Called from any thread but real-time ones: it locks and allocates.
  DeviceFacts facts() const {
    const std::lock_guard lock(mutex_);
    return facts_;
  }

  // Calls `change` with the facts, under the lock. Called from any thread but real-time ones.
  template <typename Change>
  void change_facts(Change change) {
    const std::lock_guard lock(mutex_);
    change(facts_);
  }

 private:
  mutable std::mutex mutex_;
  DeviceFacts facts_;
};

// Why there is no device or no estimator, for people; empty: there is. `facts`: of `status`. now_ns:
// CLOCK_MONOTONIC. Called from any thread but real-time ones.
inline std::string device_trouble(const SensorStatus& status, const DeviceFacts& facts, std::int64_t now_ns) {
  const char* const hangs = status.driver_watch.trouble(now_ns);
  return hangs != nullptr ? hangs : facts.trouble;
}

// What threads share about a grasp: sensors that hold one object. Thread-safe.
class GraspStatus {
 public:
  GraspStatus(std::string grasp_name, std::vector<std::size_t> its_sensors,
              std::vector<FingerPose> their_poses = {})
      : name(std::move(grasp_name)), sensors(std::move(its_sensors)), poses(std::move(their_poses)) {}

  // As configured; unique.
  const std::string name;
  // Indices into Board::sensors, in the order in which the configuration names them.
  const std::vector<std::size_t> sensors;
  // Where they are, in the same order; or none.
  const std::vector<FingerPose> poses;
  // The estimate of the grasp as a whole. Written by one thread: estimate.
  Latest<Estimate> latest;
};

// An estimate on its way to subscribers.
struct Event {
  Estimate estimate;
  // Index into Board::sensors.
  std::uint32_t sensor = 0;
  // Events of this sensor since the one before that did not fit into the queue.
  std::uint32_t lost_before = 0;
};

// Estimates of an estimate thread on their way. Pushed by that thread, popped by one thread: io.
using EventQueue = boost::lockfree::spsc_queue<Event, boost::lockfree::capacity<2048>>;

// The board. Built and destroyed while no thread runs.
struct Board {
  // In the order of the configuration.
  std::vector<std::unique_ptr<SensorStatus>> sensors;
  // In the order of the configuration.
  std::vector<std::unique_ptr<GraspStatus>> grasps;
  // One for each estimate thread.
  std::list<EventQueue> events;
  // One for each real-time thread, which writes it. Read by one thread: io.
  std::list<LogRing> logs;
  // The estimates in memory that clients map. Written by estimate threads. Made by io.
  SharedBoard shared;
  // Notified after something was written that io waits for.
  IoWakeup io_wakeup;
  // Whether io is to be woken for each event. If not, it is woken when a state or alert changed, and when the
  // queue is half full. Written by one thread: io, read by estimate threads. Relaxed: no other memory is read
  // because of it; an event that still finds it false is taken with the next one.
  std::atomic<bool> wake_for_each_event{true};
};

}  // namespace slipd
