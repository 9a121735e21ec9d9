#include "daemon/can/source.hpp"

#include "daemon/board/as_of.hpp"

namespace slipd::can {

CanSource::View CanSource::view_at(std::int64_t now_ns) const noexcept {
  View view;
  for (const std::size_t sensor : sensors_) {
    const SensorStatus& status = *board_.sensors[sensor];
    // The link before `simulated`: acquire writes `simulated` before the link becomes open.
    const DeviceLink link = status.link.load(std::memory_order_acquire);
    view.opening = view.opening || link == DeviceLink::opening;
    view.simulated = view.simulated || status.simulated.load(std::memory_order_relaxed);
  }
  view.estimate = grasp_ != nullptr ? as_of(now_ns, board_, *grasp_)
                                    : as_of(now_ns, *board_.sensors[sensors_.front()]).estimate;
  return view;
}

std::vector<CanSource> make_sources(const Board& board) {
  std::vector<CanSource> sources;
  for (std::size_t i = 0; i < board.sensors.size(); ++i) sources.push_back(CanSource::of_sensor(board, i));
  for (const auto& grasp : board.grasps) sources.push_back(CanSource::of_grasp(board, *grasp));
  return sources;
}

}  // namespace slipd::can
