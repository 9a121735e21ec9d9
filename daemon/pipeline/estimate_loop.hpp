// The estimate thread: takes each sensor's newest frame, runs its estimator and publishes the result on the
// board. It is the only writer of estimates, so it also publishes the states stale, fault and learning of
// sensors without frames. While it runs it does not allocate, lock, log or throw. It waits on one doorbell,
// at most until the next sensor becomes stale.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/pipeline/grasp_evaluator.hpp"
#include "daemon/pipeline/sensor_runtime.hpp"

namespace slipd {

// Thread-safe between the estimate thread and io.
class EstimateLoop {
 public:
  // Called from one thread: io, before the thread starts. The board has all sensors and grasps. `bell` is
  // what the thread waits on. `output`: rung when alert or state of a sensor or grasp changes; null: nobody
  // waits. All arguments outlive it.
  EstimateLoop(Board& board, std::vector<std::unique_ptr<SensorRuntime>>& runtimes,
               const AlertSettings& alerts, LogRing& log, Doorbell& bell, Doorbell* output);

  // The body of the estimate thread. Runs until `stop` is set and `bell` is rung, then retires all
  // estimators.
  void run(const std::atomic<bool>& stop) noexcept;

  // Called from any thread. Increases at least four times a second while the thread runs.
  std::uint64_t heartbeat() const noexcept { return heartbeat_.load(std::memory_order_relaxed); }

 private:
  struct SensorState {
    SensorRuntime* runtime = nullptr;
    EstimatorInstance* instance = nullptr;   // null: no estimator yet
    const FrameSlot* held = nullptr;         // the frame last taken, valid until the next take
    Published published;                     // what is on the board
    std::int64_t idle_since_ns = 0;          // time of the last frame, or of the new estimator
    bool no_data = false;                    // the board shows that there are no frames
    std::uint32_t events_lost = 0;           // since the last event that fitted into the queue
    bool event_pending = false;              // the latest estimate did not fit into the queue
    State last_output_state = State::stale;  // when the output was last rung
    Alert last_output_alert = Alert::unknown;
    Health last_health = Health::good;  // of the frame before
    bool zero_is_anothers = false;      // in the frame before
  };

  bool process(SensorState& state) noexcept;
  void estimate_frame(SensorState& state, const FrameSlot& slot, std::int64_t now_ns) noexcept;
  void publish_no_data(SensorState& state, DeviceLink link, std::int64_t now_ns) noexcept;
  void count_health(SensorState& state) noexcept;
  void tell_zero(SensorState& state, bool zeroed) noexcept;
  void publish(SensorState& state) noexcept;
  void publish_shared() noexcept;
  void publish_shared(const SensorState& state) noexcept;
  void push_event(SensorState& state, bool changed) noexcept;
  void adopt_instance(SensorState& state, EstimatorInstance* instance) noexcept;

  Board& board_;
  LogRing& log_;
  Doorbell& bell_;
  Doorbell* output_;
  GraspEvaluator grasp_evaluator_;
  std::vector<SensorState> states_;
  std::atomic<std::uint64_t> heartbeat_{0};  // relaxed: a counter
};

}  // namespace slipd
