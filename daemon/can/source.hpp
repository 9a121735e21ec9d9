// The source of one pair of CAN messages: a sensor, or a grasp's sensors together.
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/board/board.hpp"

namespace slipd::can {

// Not thread-safe. Called from one thread: can; made by io. Nothing allocates after construction.
class CanSource {
 public:
  // What is true of the source at one time.
  struct View {
    // The estimate; stale without margin if it is too old.
    Estimate estimate;
    // Whether one of its devices is a simulation.
    bool simulated = false;
    // Whether a device was not tried yet, so that `simulated` is not known.
    bool opening = false;
  };
  // `board` outlives it.
  static CanSource of_sensor(const Board& board, std::size_t sensor) { return {board, {sensor}, nullptr}; }
  static CanSource of_grasp(const Board& board, const GraspStatus& grasp) {
    return {board, grasp.sensors, &grasp};
  }

  // The source at `now_ns`, CLOCK_MONOTONIC; see as_of.
  View view_at(std::int64_t now_ns) const noexcept;

 private:
  CanSource(const Board& board, std::vector<std::size_t> sensors, const GraspStatus* grasp)
      : board_(board), sensors_(std::move(sensors)), grasp_(grasp) {}

  const Board& board_;
  std::vector<std::size_t> sensors_;
  const GraspStatus* grasp_;
};

// One for each sensor, then one for each grasp, in the order of the configuration.
std::vector<CanSource> make_sources(const Board& board);

}  // namespace slipd::can
