// Takes the newest frame of each sensor of one estimate thread, runs its estimator and publishes the result
// on the board. An acquire thread does so itself for the frame that it has just delivered, when that is short
// work and nobody else estimates (estimate_turn.hpp): waking the estimate thread would cost more than the
// estimate. The estimate thread does all else: long estimates, frames that came meanwhile, and the states
// stale, fault and learning of sensors without frames. It waits on its doorbell, at most until the next
// sensor becomes stale. Neither allocates, locks, logs or throws.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/pipeline/estimate_turn.hpp"
#include "daemon/pipeline/grasp_evaluator.hpp"
#include "daemon/pipeline/sensor_runtime.hpp"

namespace slipd {

// Thread-safe between the estimate thread, acquire threads and io.
class EstimateLoop {
 public:
  // Called from one thread: io, before the thread starts. The board has all sensors and grasps; this loop
  // adds its log and its queue of events. `sensors`: those of this thread, as indices into `runtimes`; all
  // sensors of a grasp are of the same thread. `output`: rung when alert or state of a sensor or grasp
  // changes; null: nobody waits. Board, runtimes and output outlive it.
  EstimateLoop(Board& board, std::vector<std::unique_ptr<SensorRuntime>>& runtimes,
               const std::vector<std::size_t>& sensors, const AlertSettings& alerts, Doorbell* output);

  // The body of the estimate thread. Runs until `stop` is set and the bell is rung, then retires all
  // estimators.
  void run(const std::atomic<bool>& stop) noexcept;

  // Called from acquire threads, after they published a frame of this sensor, one of this thread's. Estimates
  // it here, unless the estimate is long beside `interval_ns`, the time between two frames of the device, or
  // another thread estimates now; then that thread or the estimate thread does. Never blocks.
  void frame_delivered(std::size_t sensor, std::int64_t interval_ns) noexcept;

  // Called from any thread. What the estimate thread has to look at has changed.
  void ring() noexcept { bell_.ring(); }

  // Called from any thread. Increases at least four times a second while the thread runs.
  std::uint64_t heartbeat() const noexcept { return heartbeat_.load(std::memory_order_relaxed); }

 private:
  struct SensorState {
    std::size_t sensor = 0;  // index into Board::sensors
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
    // Mean time of an estimate, ns; 0: not known, or only the estimate thread may make it. Relaxed: an
    // independent value, for frame_delivered.
    std::atomic<std::int64_t> estimate_ns{0};
  };

  void adopt_alerts() noexcept;
  bool round(std::chrono::steady_clock::time_point& wake_at) noexcept;
  bool process(SensorState& state, std::int64_t now_ns) noexcept;
  void estimate_here(SensorState& state, std::int64_t now_ns) noexcept;
  void evaluate_grasps() noexcept;
  bool is_short(const SensorState& state, std::int64_t interval_ns) const noexcept;
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
  EventQueue& events_;
  SharedBoard::Writer shared_;
  Doorbell bell_;
  Doorbell* output_;
  GraspEvaluator grasp_evaluator_;
  std::vector<SensorState> states_;
  std::vector<std::size_t> places_;  // in states_, of each sensor of the board
  EstimateTurn<> turn_;              // of all members above
  // Until when the estimate thread sleeps, ns; 0: it has not begun. Of who has the turn.
  std::int64_t wake_at_ns_ = 0;
  std::atomic<std::uint64_t> heartbeat_{0};  // relaxed: a counter
};

}  // namespace slipd
