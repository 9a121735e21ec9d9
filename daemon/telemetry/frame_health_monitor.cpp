#include "daemon/telemetry/frame_health_monitor.hpp"

#include "daemon/rt/clock.hpp"

namespace slipd {
namespace {

// Skipped frames are reported only above this share of the received frames, 0 to 1, because a machine without
// real-time kernel skips single frames.
constexpr double kSkippedShare = 0.05;
// Seconds in a row above that share before it is reported, because all frames are skipped while an estimator
// is being made.
constexpr int kSecondsBehind = 3;
// Seconds in a row with many repeated frames before they are reported, because a quiet sensor with coarse
// steps repeats some.
constexpr int kSecondsRepeating = 3;
// Checks in a row that find a driver hanging before it is reported, because after the whole process was
// stopped for a while a first check may come before the driver's next return.
constexpr int kSecondsHanging = 2;
// Frames of a second that repeat the one before, share, 0.1 to 0.5. Below, a quiet sensor's steps may be
// coarse.
constexpr double kRepeatedShare = 0.3;

enum Problem : std::uint8_t { damaged, missing, unsent, repeating_frames, skipping };

std::string count(std::uint64_t number, const char* what) {
  return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

}  // namespace

bool measures_slower(double frames, double repeated) noexcept {
  return repeated > kRepeatedShare * frames && repeated < frames;
}

HealthTotals health_totals_of(const SensorStatus& status) {
  const FrameCounts counts = status.latest.load().counts;
  return {.received = counts.received,
          .corrupt = status.corrupt.load(std::memory_order_relaxed),
          .lost = counts.lost,
          .skipped = counts.skipped,
          .repeated = status.repeated.load(std::memory_order_relaxed),
          .events_lost = status.events_lost.load(std::memory_order_relaxed),
          .simulated = status.simulated.load(std::memory_order_relaxed),
          .driver_hangs = status.driver_watch.trouble(Now::read().monotonic_ns)};
}

std::vector<HealthNotice> FrameHealthMonitor::check(std::size_t sensor, const std::string& name,
                                                    const std::string& device, const HealthTotals& totals,
                                                    Clock::time_point now) {
  if (sensors_.size() <= sensor) sensors_.resize(sensor + 1);
  auto& [kinds, last, seconds_behind, seconds_hanging, seconds_repeating] = sensors_[sensor];
  const bool behind = static_cast<double>(totals.skipped - last.skipped) >
                      kSkippedShare * static_cast<double>(totals.received - last.received);
  seconds_behind = behind ? seconds_behind + 1 : 0;
  const bool repeating = measures_slower(static_cast<double>(totals.received - last.received),
                                         static_cast<double>(totals.repeated - last.repeated));
  seconds_hanging = totals.driver_hangs != nullptr ? seconds_hanging + 1 : 0;
  seconds_repeating = repeating ? seconds_repeating + 1 : 0;
  last = totals;
  std::vector<HealthNotice> notices;
  auto report = [&, &kinds_of = kinds](Problem problem, Cause cause, std::uint64_t total, const auto& line) {
    Kind& kind = kinds_of[problem];
    if (total == kind.last_reported || (kind.muted_until && now < *kind.muted_until)) return;
    notices.push_back({cause, name + line(total - kind.last_reported)});
    kind = {.last_reported = total, .muted_until = now + kInterval};
  };
  const std::string on = device.empty() ? ": " : " (" + device + "): ";
  if (seconds_hanging == kSecondsHanging) notices.push_back({Cause::device, name + on + totals.driver_hangs});
  report(damaged, Cause::device, totals.corrupt, [&](std::uint64_t more) {
    return on + count(more, "damaged packet") + " thrown away: the device, its cable or the bus is at fault";
  });
  report(missing, totals.simulated ? Cause::machine : Cause::bus, totals.lost, [&](std::uint64_t more) {
    if (totals.simulated)
      return on + count(more, "frame") +
             " were not simulated in time: this machine is too slow for this rate";
    return on + count(more, "frame") +
           " never came whole (by the device's count, if it has one, else by messages that are missing): the "
           "device "
           "or the bus is too slow";
  });
  report(unsent, Cause::slipd, totals.events_lost, [&](std::uint64_t more) {
    return ": " + count(more, "estimate") + " not sent to subscribers: slipd's own io thread was held up";
  });
  if (seconds_repeating >= kSecondsRepeating) {
    report(repeating_frames, Cause::configuration, totals.repeated, [&](std::uint64_t more) {
      return on + count(more, "frame") +
             " repeated the one before, and count for nothing: read the sensor as often as it measures "
             "(rate_hz)";
    });
  }
  if (seconds_behind >= kSecondsBehind) {
    report(skipping, Cause::machine, totals.skipped, [&](std::uint64_t more) {
      return ": " + count(more, "frame") +
             " skipped: this machine is too slow for this rate and method; choose a cheaper estimator.method "
             "or a "
             "lower rate_hz";
    });
  }
  return notices;
}

}  // namespace slipd
