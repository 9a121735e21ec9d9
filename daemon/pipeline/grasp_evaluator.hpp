// Estimates grasps from the estimates of their sensors. Part of the estimate thread.
#pragma once

#include <vector>

#include "core/grasp/grasp.hpp"
#include "daemon/board/board.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: estimate, except for the constructor.
class GraspEvaluator {
 public:
  // For all grasps that are on the board. `board` outlives it. Allocates; nothing else does.
  GraspEvaluator(Board& board, const AlertSettings& alerts);

  // A new estimate of this sensor is on the board.
  void mark_updated(std::size_t sensor) noexcept;

  // Evaluates and publishes each grasp with a new estimate. Called after a round over all sensors, so that
  // frames of one moment are used together. True if alert or state of a grasp changed.
  bool evaluate() noexcept;

  // Writes the latest estimate of each grasp into the shared memory.
  void publish_shared() noexcept;

 private:
  struct GraspState {
    GraspStatus* status;
    GraspTracker tracker;
    std::vector<Estimate> members;
    bool updated = false;
    State last_state = State::stale;
    Alert last_alert = Alert::unknown;
  };
  void publish_shared(std::size_t grasp, const Estimate& estimate) noexcept;

  Board& board_;
  std::vector<GraspState> grasp_states_;
};

}  // namespace slipd
