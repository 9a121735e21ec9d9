// The estimate thread's part for grasps: judges again each whose sensors have something new.
#pragma once

#include <vector>

#include "core/estimate/grasp.hpp"
#include "daemon/board/board.hpp"

namespace slipd {

class GraspEvaluator {
 public:
  // One for each grasp that is on the board by now.
  GraspEvaluator(Board& board, const AlertSettings& alerts);

  // A sensor's new estimate is on the board.
  void touch(std::size_t sensor) noexcept;

  // After a round over all sensors, so that frames of one moment are judged together. True if a grasp's alert
  // or state has changed.
  bool judge() noexcept;

 private:
  struct GraspState {
    GraspStatus* status;
    GraspTracker judge;
    std::vector<Estimate> members;
    bool touched = false;
    State said_state = State::stale;
    Alert said_alert = Alert::none;
  };
  const Board& board_;
  std::vector<GraspState> grasp_states_;
};

}  // namespace slipd
