#include "daemon/pipeline/grasp_evaluator.hpp"

#include <algorithm>

namespace slipd {

GraspEvaluator::GraspEvaluator(Board& board, const AlertSettings& alerts) : board_(board) {
  for (const auto& status : board.grasps) {
    grasp_states_.push_back({.status = status.get(),
                             .judge = GraspTracker(alerts),
                             .members = std::vector<Estimate>(status->sensors.size())});
  }
}

void GraspEvaluator::touch(std::size_t sensor) noexcept {
  for (GraspState& grasp_state : grasp_states_) {
    const auto& sensors = grasp_state.status->sensors;
    grasp_state.touched =
        grasp_state.touched || std::find(sensors.begin(), sensors.end(), sensor) != sensors.end();
  }
}

bool GraspEvaluator::judge() noexcept {
  bool changed = false;
  for (GraspState& grasp_state : grasp_states_) {
    if (!grasp_state.touched) continue;
    grasp_state.touched = false;
    for (std::size_t i = 0; i < grasp_state.members.size(); ++i)
      grasp_state.members[i] = board_.sensors[grasp_state.status->sensors[i]]->latest.load().estimate;
    const Estimate now = grasp_state.judge.judge(grasp_state.members);
    grasp_state.status->latest.store(now);
    changed = changed || now.state != grasp_state.said_state || now.alert != grasp_state.said_alert;
    grasp_state.said_state = now.state;
    grasp_state.said_alert = now.alert;
  }
  return changed;
}

}  // namespace slipd
