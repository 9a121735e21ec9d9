// Estimates grasps from the estimates of their sensors. Part of an estimate thread.
#pragma once

#include <vector>

#include "core/grasp/grasp.hpp"
#include "daemon/board/board.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: estimate, except for the constructor.
class GraspEvaluator {
 public:
  // For the grasps on the board that have these sensors. `shared` is what the thread writes. All references
  // outlive it. Allocates; nothing else does.
  GraspEvaluator(Board& board, const std::vector<std::size_t>& sensors, const AlertSettings& alerts,
                 SharedBoard::Writer& shared);

  // A new estimate of this sensor is on the board.
  void mark_updated(std::size_t sensor) noexcept;

  // Evaluates and publishes each grasp with a new estimate. Called after a round over all sensors, so that
  // frames of one moment are used together. True if alert or state of a grasp changed.
  bool evaluate() noexcept;

  // Writes the latest estimate of each grasp into the shared memory.
  void publish_shared() noexcept;

 private:
  struct GraspState {
    std::size_t grasp;  // index into Board::grasps
    GraspStatus* status;
    GraspTracker tracker;
    std::vector<Estimate> members;
    bool updated = false;
    State last_state = State::stale;
    Alert last_alert = Alert::unknown;
  };
  void publish_shared(const GraspState& grasp_state, const Estimate& estimate) noexcept;

  Board& board_;
  SharedBoard::Writer& shared_;
  std::vector<GraspState> grasp_states_;
};

}  // namespace slipd
