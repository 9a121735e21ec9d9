#include "daemon/can/source.hpp"

#include <algorithm>

namespace slipd::can {
namespace {

// Whether an estimate is published once and holds until another replaces it, however old it is. `learning`
// without a force is one of these: the estimator is being made.
bool holds_until_replaced(const Estimate& latest) noexcept {
  return latest.state == State::stale || latest.state == State::fault ||
         (latest.state == State::learning && !latest.normal_n);
}

}  // namespace

CanSource::View CanSource::view_at(std::int64_t now_ns) const noexcept {
  View view;
  std::int64_t stale_after_ns = 0;
  for (const std::size_t sensor : sensors_) {
    const SensorStatus& status = *board_.sensors[sensor];
    // The link before `simulated`: acquire writes `simulated` before the link becomes open.
    const DeviceLink link = status.link.load(std::memory_order_acquire);
    view.opening = view.opening || link == DeviceLink::opening;
    view.simulated = view.simulated || status.simulated.load(std::memory_order_relaxed);
    stale_after_ns = std::max(stale_after_ns, status.stale_after_ns.load(std::memory_order_relaxed));
  }
  const Estimate latest =
      grasp_ != nullptr ? grasp_->latest.load() : board_.sensors[sensors_.front()]->latest.load().estimate;
  if (holds_until_replaced(latest) || now_ns - latest.published_ns <= stale_after_ns) {
    view.estimate = latest;
  } else {
    view.estimate.sequence = latest.sequence;
    view.estimate.time_ns = latest.time_ns;
    view.estimate.published_ns = latest.published_ns;
    view.estimate.alert = without_frames(latest.alert);
    view.estimate.alert_cause = latest.alert_cause;
  }
  return view;
}

std::vector<CanSource> make_sources(const Board& board) {
  std::vector<CanSource> sources;
  for (std::size_t i = 0; i < board.sensors.size(); ++i) sources.push_back(CanSource::of_sensor(board, i));
  for (const auto& grasp : board.grasps) sources.push_back(CanSource::of_grasp(board, *grasp));
  return sources;
}

}  // namespace slipd::can
