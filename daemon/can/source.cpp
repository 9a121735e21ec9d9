#include "daemon/can/source.hpp"

#include <algorithm>

namespace slipd::can {
namespace {

// What the estimate thread says once and means until it says otherwise. `learning` is that only without a
// frame, while a model is made.
bool lasting(const Estimate& said) noexcept {
  return said.state == State::stale || said.state == State::fault ||
         (said.state == State::learning && !said.normal_n);
}

}  // namespace

CanSource::View CanSource::look(std::int64_t now_ns) const noexcept {
  View view;
  std::int64_t stale_after_ns = 0;
  for (const std::size_t sensor : sensors_) {
    const SensorStatus& status = *board_.sensors[sensor];
    // The link first: once it is open, the acquire thread has said whether it is simulated.
    const Link link = status.link.load(std::memory_order_acquire);
    view.opening = view.opening || link == Link::opening;
    view.simulated = view.simulated || status.simulated.load(std::memory_order_relaxed);
    stale_after_ns = std::max(stale_after_ns, status.stale_after_ns.load(std::memory_order_relaxed));
  }
  const Estimate said =
      grasp_ != nullptr ? grasp_->latest.load() : board_.sensors[sensors_.front()]->latest.load().estimate;
  if (lasting(said) || now_ns - said.published_ns <= stale_after_ns) {
    view.estimate = said;
  } else {
    view.estimate.sequence = said.sequence;
    view.estimate.time_ns = said.time_ns;
    view.estimate.published_ns = said.published_ns;
    view.estimate.alert = said.alert;
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
