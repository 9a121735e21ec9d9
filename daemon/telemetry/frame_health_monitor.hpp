// What goes wrong with frames, told to the log: what, how often, and whose fault it most likely is. At most
// once a minute for each sensor and kind, with the number since the last time, so that a bad cable does not
// fill the disk. io thread.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/board/board.hpp"

namespace slipd {

// The running totals of one sensor that complaints are made of.
struct HealthTotals {
  std::uint64_t received = 0;
  std::uint64_t corrupt = 0, lost = 0, skipped = 0, events_lost = 0;
  bool simulated = false;
};
HealthTotals health_totals_of(const SensorStatus& status);

struct HealthNotice {
  Cause cause = Cause::none;
  std::string text;
};

class FrameHealthMonitor {
 public:
  using Clock = std::chrono::steady_clock;

  // About once a second for each sensor. What is to be logged, if anything.
  std::vector<HealthNotice> look(std::size_t sensor, const std::string& name, const std::string& device,
                                 const HealthTotals& totals, Clock::time_point now);

 private:
  static constexpr auto kInterval = std::chrono::minutes(1);
  static constexpr std::size_t kKinds = 4;
  struct Kind {
    std::uint64_t told = 0;  // of the total, when it was last told
    std::optional<Clock::time_point> quiet_until;
  };
  struct Sensor {
    std::array<Kind, kKinds> kinds;
    HealthTotals last;
    int seconds_behind = 0;  // looks in a row that found many skipped frames
  };
  std::vector<Sensor> sensors_;
};

}  // namespace slipd
