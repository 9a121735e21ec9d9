// The estimate thread: takes every sensor's newest frame, asks its estimator, and puts the answer on the
// board. It alone writes the board's estimates, so it alone says when a sensor is stale or gone. Once it runs
// it allocates, locks, logs and throws nothing; it waits on the doorbell only, at most until the next stale
// deadline.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/pipeline/grasp_evaluator.hpp"
#include "daemon/pipeline/sensor_runtime.hpp"

namespace slipd {

class EstimateLoop {
 public:
  // The board has its sensors and grasps. `output`, if any: rung when the alert level or the state of one of
  // them changes.
  EstimateLoop(Board& board, std::vector<std::unique_ptr<SensorRuntime>>& runtimes,
               const AlertSettings& alerts, LogRing& log, Doorbell& bell, Doorbell* output);

  // The thread's body: until `stop`, after which every lane is retired.
  void run(const std::atomic<bool>& stop) noexcept;

  // io: rises as long as the thread goes round, at least four times a second.
  std::uint64_t heartbeat() const noexcept { return heartbeat_.load(std::memory_order_relaxed); }

 private:
  struct SensorState {
    SensorRuntime* runtime = nullptr;
    EstimatorInstance* instance = nullptr;  // null: no estimator yet
    const FrameSlot* held = nullptr;        // the frame last taken, valid until the next
    Published reading;                      // as last put on the board
    std::int64_t since_ns = 0;              // the last frame came, or the lane was laid
    bool quiet = false;                     // the board says that nothing comes; not to be said again
    std::uint32_t events_lost = 0;          // since the last event that found room
    bool event_owed = false;
    State said_state = State::stale;  // when the output was last rung
    Alert said_alert = Alert::none;
  };

  bool work(SensorState& state) noexcept;
  void answer(SensorState& state, const FrameSlot& slot, std::int64_t now_ns) noexcept;
  void say_quiet(SensorState& state, Link link, std::int64_t now_ns) noexcept;
  void publish(SensorState& state) noexcept;
  void push_event(SensorState& state) noexcept;
  void take_instance(SensorState& state, EstimatorInstance* instance) noexcept;

  Board& board_;
  LogRing& log_;
  Doorbell& bell_;
  Doorbell* output_;
  GraspEvaluator grasp_evaluator_;
  std::vector<SensorState> states_;
  std::atomic<std::uint64_t> heartbeat_{0};  // relaxed: a number of its own
};

}  // namespace slipd
