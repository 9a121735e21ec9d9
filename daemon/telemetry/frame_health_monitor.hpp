// Finds problems with frames (corrupt, lost, skipped) and drivers that hang, for the log: what, how many, and
// the most likely cause. Each kind is reported at most once a minute for a sensor, with the number since the
// last report.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/board/board.hpp"

namespace slipd {

// Totals of one sensor since the start.
struct HealthTotals {
  // Frames delivered by the driver.
  std::uint64_t received = 0;
  // Packets or frames that the driver dropped.
  std::uint64_t corrupt = 0;
  // Frames missing by the device's sequence numbers.
  std::uint64_t lost = 0;
  // Frames replaced before they were estimated.
  std::uint64_t skipped = 0;
  // Frames that are the one before once more.
  std::uint64_t repeated = 0;
  // Estimates that did not reach io.
  std::uint64_t events_lost = 0;
  // Whether the device is a simulation.
  bool simulated = false;
  // That its driver hangs, see DriverWatch; null: it does not.
  const char* driver_hangs = nullptr;
};
// The present totals. Called from any thread.
HealthTotals health_totals_of(const SensorStatus& status);

// Whether a sensor measures less often than frames come: of the frames of a second many repeat the one
// before, and not all. Called from any thread.
bool measures_slower(double frames, double repeated) noexcept;

// A problem to be logged.
struct HealthNotice {
  // What most likely causes it.
  Cause cause = Cause::none;
  // For people, with the sensor's name.
  std::string text;
};

// Not thread-safe. Called from one thread: io.
class FrameHealthMonitor {
 public:
  using Clock = std::chrono::steady_clock;

  // To be called once a second for each sensor. Returns what is to be logged. `device`: its description, may
  // be empty.
  std::vector<HealthNotice> check(std::size_t sensor, const std::string& name, const std::string& device,
                                  const HealthTotals& totals, Clock::time_point now);

 private:
  // Least time between two reports of one kind for one sensor. Shorter: a lasting fault fills the journal.
  static constexpr auto kInterval = std::chrono::minutes(1);
  static constexpr std::size_t kKinds = 5;
  struct Kind {
    std::uint64_t last_reported = 0;  // the total at the last report
    std::optional<Clock::time_point> muted_until;
  };
  struct Sensor {
    std::array<Kind, kKinds> kinds;
    HealthTotals last;
    int seconds_behind = 0;     // checks in a row that found many skipped frames
    int seconds_hanging = 0;    // checks in a row that found its driver hanging
    int seconds_repeating = 0;  // checks in a row that found many repeated ones, and new ones
  };
  std::vector<Sensor> sensors_;
};

}  // namespace slipd
