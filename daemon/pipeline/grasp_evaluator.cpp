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
    publish_shared(static_cast<std::size_t>(&grasp_state - grasp_states_.data()), now);
    changed = changed || now.state != grasp_state.last_state || now.alert != grasp_state.last_alert;
    grasp_state.last_state = now.state;
    grasp_state.last_alert = now.alert;
  }
  return changed;
}

void GraspEvaluator::publish_shared() noexcept {
  for (std::size_t i = 0; i < grasp_states_.size(); ++i)
    publish_shared(i, grasp_states_[i].status->latest.load());
}

// A grasp is as old as the oldest of its sensors, and simulated if one of them is.
void GraspEvaluator::publish_shared(std::size_t grasp, const Estimate& estimate) noexcept {
  const GraspState& grasp_state = grasp_states_[grasp];
  const auto& sensors = grasp_state.status->sensors;
  std::int64_t oldest_ns = grasp_state.members.empty() ? 0 : grasp_state.members.front().time_ns;
  bool simulated = false;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    oldest_ns = std::min(oldest_ns, grasp_state.members[i].time_ns);  // 0: it had no frame
    simulated = simulated || board_.sensors[sensors[i]]->simulated.load(std::memory_order_relaxed);
  }
  const std::size_t first = sensors.empty() ? 0 : sensors[estimate.first_member % sensors.size()];
  if (board_.shared.publish_grasp(grasp, estimate, oldest_ns, simulated, first)) board_.io_wakeup.notify();
}

}  // namespace slipd
