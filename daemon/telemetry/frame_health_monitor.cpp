#include "daemon/telemetry/frame_health_monitor.hpp"

namespace slipd {
namespace {

// Skipped frames are reported only above this share of the received frames, 0 to 1, because a machine without
// real-time kernel skips single frames.
constexpr double kSkippedShare = 0.05;
// Seconds in a row above that share before it is reported, because all frames are skipped while an estimator
// is being made.
constexpr int kSecondsBehind = 3;

std::string count(std::uint64_t number, const char* what) {
  return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

}  // namespace

HealthTotals health_totals_of(const SensorStatus& status) {
  const FrameCounts counts = status.latest.load().counts;
  return {.received = counts.received,
          .corrupt = status.corrupt.load(std::memory_order_relaxed),
          .lost = counts.lost,
          .skipped = counts.skipped,
          .events_lost = status.events_lost.load(std::memory_order_relaxed),
          .simulated = status.simulated.load(std::memory_order_relaxed)};
}

std::vector<HealthNotice> FrameHealthMonitor::check(std::size_t sensor, const std::string& name,
                                                    const std::string& device, const HealthTotals& totals,
                                                    Clock::time_point now) {
  if (sensors_.size() <= sensor) sensors_.resize(sensor + 1);
  auto& [kinds, last, seconds_behind] = sensors_[sensor];
  const bool behind = static_cast<double>(totals.skipped - last.skipped) >
                      kSkippedShare * static_cast<double>(totals.received - last.received);
  seconds_behind = behind ? seconds_behind + 1 : 0;
  last = totals;
  std::vector<HealthNotice> notices;
  auto report = [&, &kinds_of = kinds, which = std::size_t{0}](Cause cause, std::uint64_t total,
                                                               const auto& line) mutable {
    Kind& kind = kinds_of[which++];
    if (total == kind.last_reported || (kind.muted_until && now < *kind.muted_until)) return;
    notices.push_back({cause, name + line(total - kind.last_reported)});
    kind = {.last_reported = total, .muted_until = now + kInterval};
  };
  const std::string on = device.empty() ? ": " : " (" + device + "): ";
  report(Cause::device, totals.corrupt, [&](std::uint64_t more) {
    return on + count(more, "damaged packet") + " thrown away: the device, its cable or the bus is at fault";
  });
  report(totals.simulated ? Cause::machine : Cause::bus, totals.lost, [&](std::uint64_t more) {
    if (totals.simulated)
      return on + count(more, "frame") +
             " were not simulated in time: this machine is too slow for this rate";
    return on + count(more, "frame") +
           " never came whole (by the device's count, if it has one, else by messages that are missing): the "
           "device "
           "or the bus is too slow";
  });
  report(Cause::slipd, totals.events_lost, [&](std::uint64_t more) {
    return ": " + count(more, "estimate") + " not sent to subscribers: slipd's own io thread was held up";
  });
  if (seconds_behind >= kSecondsBehind) {
    report(Cause::machine, totals.skipped, [&](std::uint64_t more) {
      return ": " + count(more, "frame") +
             " skipped: this machine is too slow for this rate and method; choose a cheaper estimator.method "
             "or a "
             "lower rate_hz";
    });
  }
  return notices;
}

}  // namespace slipd
