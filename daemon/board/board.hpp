// What the real-time threads tell everybody else: one panel per sensor, one ring of events, log rings. Made
// once, before any thread; its size never changes while it lives.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/estimate/estimate.hpp"
#include "core/frame/layout.hpp"
#include "core/model/work_precision.hpp"
#include "daemon/board/bias_channel.hpp"
#include "daemon/board/frame_copy.hpp"
#include "daemon/board/latency.hpp"
#include "daemon/board/record_tap.hpp"
#include "daemon/rt/latest.hpp"
#include "daemon/rt/log_ring.hpp"
#include "daemon/rt/wake.hpp"

namespace slipd {

// Frames of one sensor up to and with the one last answered. received = estimated + skipped, always.
struct Counts {
  std::uint64_t received = 0;   // handed over by the driver
  std::uint64_t estimated = 0;  // answered by an Estimate
  std::uint64_t skipped = 0;    // replaced by a newer one before the estimator came to them
  std::uint64_t gaps = 0;       // jumps in the device's sequence numbers
  std::uint64_t lost = 0;       // frames that are missing in those gaps
};

struct Published {
  Estimate estimate;
  Counts counts;
};

enum class Link : std::uint8_t {
  opening,  // first attempt under way
  open,
  absent,  // not there or lost; being reopened
  ended    // a recording is over
};

// Known once the device is open. Written by set-up threads, read by io; no real-time thread comes near it.
struct DeviceFacts {
  std::string description, serial;
  SensorClass sensor_class = SensorClass::array3;
  std::optional<TaxelLayout> layout;
  double rate_hz = 0;        // 0: the device does not say
  std::string method;        // empty until an estimator is ready
  WorkPrecision tradeoff;    // what `auto` chose it from, or came with its model; else without rows
  std::string trouble;       // why it is absent; empty: it is not
  std::string zero_trouble;  // why its zero was not restored, or is not kept; empty: it is
};

class SensorStatus {
 public:
  SensorStatus(std::string sensor_name, std::string driver_name)
      : name(std::move(sensor_name)), driver(std::move(driver_name)) {}

  const std::string name, driver;
  Latest<Published> latest;  // estimate thread writes
  LatencyHistogram latency;  // estimate thread writes: sample → published
  FrameCopy frame;           // io and estimate thread
  BiasChannel zero;
  RecordTap flight_tap;  // acquire thread and the flight recorder
  RecordTap tap;         // acquire thread and whoever records
  // Acquire thread writes, while setting up. Relaxed: nothing else is read on its word.
  std::atomic<bool> simulated{false};
  // Estimate thread writes, once it knows the device: after so long without a frame an estimate holds no
  // more. Relaxed: a number of its own.
  std::atomic<std::int64_t> stale_after_ns{20'000'000};
  // Acquire thread writes, with release: whoever reads it with acquire (EstimateLoop::work, can's CanSource)
  // finds the frames that came before. Relaxed where it is only told.
  std::atomic<Link> link{Link::opening};
  // Acquire thread writes. Relaxed: each is a number of its own.
  std::atomic<std::uint64_t> corrupt{0}, timeouts{0}, reconnects{0};
  std::atomic<std::uint64_t> events_lost{0};  // estimate thread writes: the event ring was full. Relaxed, too

  DeviceFacts facts() const {
    const std::lock_guard lock(mutex_);
    return facts_;
  }
  template <typename Change>
  void change_facts(Change change) {
    const std::lock_guard lock(mutex_);
    change(facts_);
  }

 private:
  mutable std::mutex mutex_;
  DeviceFacts facts_;
};

// Sensors that hold one object.
class GraspStatus {
 public:
  GraspStatus(std::string grasp_name, std::vector<std::size_t> its_sensors)
      : name(std::move(grasp_name)), sensors(std::move(its_sensors)) {}

  const std::string name;
  const std::vector<std::size_t> sensors;  // on the board
  Latest<Estimate> latest;                 // estimate thread writes: of all of them together
};

struct Event {
  Estimate estimate;
  std::uint32_t sensor = 0;
  std::uint32_t lost_before =
      0;  // events of this sensor for which the ring had no room, just before this one
};

struct Board {
  std::vector<std::unique_ptr<SensorStatus>> sensors;
  std::vector<std::unique_ptr<GraspStatus>> grasps;
  boost::lockfree::spsc_queue<Event, boost::lockfree::capacity<2048>> events;  // estimate thread → io
  std::deque<LogRing> logs;  // one for each real-time thread
  Wake io;
};

}  // namespace slipd
