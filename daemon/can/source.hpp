// What one pair of CAN messages speaks of: a sensor, or a grasp's sensors together. Looks at the board and
// says what is true now. CAN thread; nothing allocates once it is made.
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/board/board.hpp"

namespace slipd::can {

class CanSource {
 public:
  struct View {
    Estimate estimate;  // without margin where none holds
    bool simulated = false;
    bool opening = false;  // a device was not tried yet, so that nobody knows whether it is a simulated one
  };
  static CanSource of_sensor(const Board& board, std::size_t sensor) { return {board, {sensor}, nullptr}; }
  static CanSource of_grasp(const Board& board, const GraspStatus& grasp) {
    return {board, grasp.sensors, &grasp};
  }

  // Now. An estimate older than stale_after is stale even if the estimate thread does not say so: then it
  // stands still itself. The alert stands with it.
  View look(std::int64_t now_ns) const noexcept;

 private:
  CanSource(const Board& board, std::vector<std::size_t> sensors, const GraspStatus* grasp)
      : board_(board), sensors_(std::move(sensors)), grasp_(grasp) {}

  const Board& board_;
  std::vector<std::size_t> sensors_;
  const GraspStatus* grasp_;
};

// A sensor each, then a grasp each, in the order of the configuration.
std::vector<CanSource> make_sources(const Board& board);

}  // namespace slipd::can
