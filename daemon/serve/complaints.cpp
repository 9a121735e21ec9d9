#include "daemon/serve/complaints.hpp"

namespace slipd {
namespace {

// A machine that is no real-time one misses a frame now and then; that alone is no news.
constexpr double kSkippedShare = 0.05;

std::string count(std::uint64_t number, const char* what) {
  return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

}  // namespace

Troubles troubles_of(const Panel& panel) {
  const Counts counts = panel.latest.load().counts;
  return {.received = counts.received,
          .corrupt = panel.corrupt.load(std::memory_order_relaxed),
          .lost = counts.lost,
          .skipped = counts.skipped,
          .events_lost = panel.events_lost.load(std::memory_order_relaxed)};
}

std::vector<std::string> Complaints::look(std::size_t sensor, const std::string& name,
                                          const std::string& device, const Troubles& totals,
                                          Clock::time_point now) {
  if (sensors_.size() <= sensor) sensors_.resize(sensor + 1);
  const std::string on = device.empty() ? "" : " (" + device + ")";
  const std::array<std::uint64_t, kKinds> seen{totals.corrupt, totals.lost, totals.skipped,
                                               totals.events_lost};
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < kKinds; ++i) {
    Kind& kind = sensors_[sensor][i];
    const std::uint64_t more = seen[i] - kind.told;
    const std::uint64_t frames = totals.received - kind.received;
    if (more == 0 || (kind.quiet_until && now < *kind.quiet_until)) continue;
    switch (i) {
      case 0:
        lines.push_back(name + on + ": " + count(more, "damaged packet") +
                        " thrown away: the device, its cable or the bus is at fault");
        break;
      case 1:
        lines.push_back(name + on + ": " + count(more, "frame") +
                        " never came, by the device's own numbering: the device or the bus is too slow");
        break;
      case 2:
        if (static_cast<double>(more) < kSkippedShare * static_cast<double>(frames)) continue;
        lines.push_back(name + ": " + count(more, "frame") + " of " + std::to_string(frames) +
                        " skipped: this machine is too slow for this rate and method; choose a cheaper "
                        "estimator.method or a lower rate_hz");
        break;
      default:
        lines.push_back(name + ": " + count(more, "estimate") +
                        " not told to subscribers: slipd's own io thread was held up");
    }
    kind = {.told = seen[i], .received = totals.received, .quiet_until = now + kInterval};
  }
  return lines;
}

}  // namespace slipd
