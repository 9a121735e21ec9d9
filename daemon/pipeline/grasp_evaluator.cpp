#include "daemon/pipeline/grasp_evaluator.hpp"

#include <algorithm>

namespace slipd {

GraspEvaluator::GraspEvaluator(Board& board, const AlertSettings& alerts) : board_(board) {
  for (const auto& status : board.grasps) {
    grasp_states_.push_back({.status = status.get(),
                             .tracker = GraspTracker(alerts, status->poses),
                             .members = std::vector<Estimate>(status->sensors.size())});
  }
}

void GraspEvaluator::mark_updated(std::size_t sensor) noexcept {
  for (GraspState& grasp_state : grasp_states_) {
    const auto& sensors = grasp_state.status->sensors;
    grasp_state.updated =
        grasp_state.updated || std::find(sensors.begin(), sensors.end(), sensor) != sensors.end();
  }
}

bool GraspEvaluator::evaluate() noexcept {
  bool changed = false;
  for (GraspState& grasp_state : grasp_states_) {
    if (!grasp_state.updated) continue;
    grasp_state.updated = false;
    for (std::size_t i = 0; i < grasp_state.members.size(); ++i)
      grasp_state.members[i] = board_.sensors[grasp_state.status->sensors[i]]->latest.load().estimate;
    const Estimate now = grasp_state.tracker.judge(grasp_state.members);
    grasp_state.status->latest.store(now);
    changed = changed || now.state != grasp_state.last_state || now.alert != grasp_state.last_alert;
    grasp_state.last_state = now.state;
    grasp_state.last_alert = now.alert;
  }
  return changed;
}

}  // namespace slipd
