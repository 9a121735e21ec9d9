#include "daemon/pipeline/grasp_evaluator.hpp"

#include <algorithm>

namespace slipd {

GraspEvaluator::GraspEvaluator(Board& board, const std::vector<std::size_t>& sensors,
                               const AlertSettings& alerts, SharedBoard::Writer& shared)
    : board_(board), shared_(shared) {
  for (std::size_t grasp = 0; grasp < board.grasps.size(); ++grasp) {
    GraspStatus& status = *board.grasps[grasp];
    if (std::find(sensors.begin(), sensors.end(), status.sensors.front()) == sensors.end()) continue;
    grasp_states_.push_back({.grasp = grasp,
                             .status = &status,
                             .tracker = GraspTracker(alerts, status.poses),
                             .members = std::vector<Estimate>(status.sensors.size())});
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
    publish_shared(grasp_state, now);
    changed = changed || now.state != grasp_state.last_state || now.alert != grasp_state.last_alert;
    grasp_state.last_state = now.state;
    grasp_state.last_alert = now.alert;
  }
  return changed;
}

void GraspEvaluator::publish_shared() noexcept {
  for (const GraspState& grasp_state : grasp_states_)
    publish_shared(grasp_state, grasp_state.status->latest.load());
}

// A grasp is as old as the oldest of its sensors, and simulated if one of them is.
void GraspEvaluator::publish_shared(const GraspState& grasp_state, const Estimate& estimate) noexcept {
  const auto& sensors = grasp_state.status->sensors;
  std::int64_t oldest_ns = grasp_state.members.empty() ? 0 : grasp_state.members.front().time_ns;
  bool simulated = false;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    oldest_ns = std::min(oldest_ns, grasp_state.members[i].time_ns);  // 0: it had no frame
    simulated = simulated || board_.sensors[sensors[i]]->simulated.load(std::memory_order_relaxed);
  }
  const std::size_t first = sensors.empty() ? 0 : sensors[estimate.first_member % sensors.size()];
  if (shared_.publish_grasp(grasp_state.grasp, estimate, oldest_ns, simulated, first))
    board_.io_wakeup.notify();
}

}  // namespace slipd
