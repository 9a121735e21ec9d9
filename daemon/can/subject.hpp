// What one pair of CAN messages speaks of: a sensor, or a grasp's sensors together. Looks at the board and
// says what is true now. CAN thread; nothing allocates once it is made.
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "config/settings.hpp"
#include "core/estimate/alert.hpp"
#include "daemon/board/board.hpp"

namespace slipd::can {

class Subject {
 public:
  // `sensors`: indices on the board; more than one, or one that `is_grasp`, are judged together.
  Subject(const Settings& settings, const Board& board, std::vector<std::size_t> sensors, bool is_grasp);

  struct View {
    Estimate estimate;  // without margin and alert where none holds
    bool simulated = false;
    bool opening = false;  // a device was not tried yet, so that nobody knows whether it is a simulated one
  };

  // Now. An estimate older than its sensor's stale_after is stale even if the estimate thread does not say
  // so: then it stands still itself.
  View look(std::int64_t now_ns) noexcept;

 private:
  Estimate sensor_now(std::size_t sensor, std::int64_t now_ns) const noexcept;
  Estimate together(std::int64_t now_ns) noexcept;

  const Settings& settings_;
  const Board& board_;
  std::vector<std::size_t> sensors_;
  bool is_grasp_;
  std::vector<Estimate> members_;
  // Of a grasp: its alert has the hysteresis and the forecast of a sensor's.
  AlertLogic alert_;
  SlipForecast forecast_;
  Estimate last_;
};

// A sensor each, then a grasp each, in the order of the configuration.
std::vector<Subject> make_subjects(const Settings& settings, const Board& board);

}  // namespace slipd::can
