#include "daemon/pipeline/grasp_evaluator.hpp"

#include <algorithm>

namespace slipd {

Grasping::Grasping(Board& board, const AlertSettings& alerts) : board_(board) {
  for (const auto& panel : board.grasps) {
    hands_.push_back({.panel = panel.get(),
                      .judge = GraspJudge(alerts),
                      .members = std::vector<Estimate>(panel->sensors.size())});
  }
}

void Grasping::touch(std::size_t sensor) noexcept {
  for (Hand& hand : hands_) {
    const auto& sensors = hand.panel->sensors;
    hand.touched = hand.touched || std::find(sensors.begin(), sensors.end(), sensor) != sensors.end();
  }
}

bool Grasping::judge() noexcept {
  bool changed = false;
  for (Hand& hand : hands_) {
    if (!hand.touched) continue;
    hand.touched = false;
    for (std::size_t i = 0; i < hand.members.size(); ++i)
      hand.members[i] = board_.sensors[hand.panel->sensors[i]]->latest.load().estimate;
    const Estimate now = hand.judge.judge(hand.members);
    hand.panel->latest.store(now);
    changed = changed || now.state != hand.said_state || now.alert != hand.said_alert;
    hand.said_state = now.state;
    hand.said_alert = now.alert;
  }
  return changed;
}

}  // namespace slipd
