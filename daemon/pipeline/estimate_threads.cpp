#include "daemon/pipeline/estimate_threads.hpp"

#include <algorithm>
#include <numeric>
#include <string>
#include <thread>

namespace slipd {
namespace {

constexpr std::size_t kStackBytes = std::size_t{512} * 1024;
// Sensors for each estimate thread. At 1 kHz and 8 us an estimate (docs/growth.md) they take half a core, so
// that a scan of all of them is done before the next one. Fewer: threads that nothing needs. More: frames are
// skipped.
constexpr std::size_t kSensorsOfThread = 64;

}  // namespace

std::vector<std::vector<std::size_t>> share_out(std::size_t sensors,
                                                const std::vector<std::vector<std::size_t>>& grasps,
                                                std::size_t threads) {
  // Of each sensor, the first one of those that grasps join it with.
  std::vector<std::size_t> first(sensors);
  std::iota(first.begin(), first.end(), std::size_t{0});
  for (const auto& grasp : grasps) {
    for (const std::size_t member : grasp) {
      const auto [least, most] = std::minmax(first[grasp.front()], first[member]);
      std::replace(first.begin(), first.end(), std::size_t{most}, std::size_t{least});
    }
  }
  std::vector<std::vector<std::size_t>> together(sensors);
  for (std::size_t sensor = 0; sensor < sensors; ++sensor) together[first[sensor]].push_back(sensor);
  // The largest first, each to the thread that has the fewest.
  std::stable_sort(together.begin(), together.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  std::vector<std::vector<std::size_t>> parts(threads);
  for (const auto& group : together) {
    auto& part = *std::min_element(parts.begin(), parts.end(),
                                   [](const auto& a, const auto& b) { return a.size() < b.size(); });
    part.insert(part.end(), group.begin(), group.end());
  }
  std::erase_if(parts, [](const auto& part) { return part.empty(); });
  for (auto& part : parts) std::sort(part.begin(), part.end());
  return parts;
}

std::size_t estimate_threads(const RealtimeSettings& settings, std::size_t sensors) {
  if (settings.estimate_threads > 0) return static_cast<std::size_t>(settings.estimate_threads);
  const std::size_t cpus =
      settings.cpus.empty() ? std::max(1U, std::thread::hardware_concurrency()) : settings.cpus.size();
  return std::clamp<std::size_t>((sensors + kSensorsOfThread - 1) / kSensorsOfThread, 1, cpus);
}

EstimateThreads::EstimateThreads(const RealtimeSettings& realtime, const AlertSettings& alerts, Board& board,
                                 std::vector<std::unique_ptr<SensorRuntime>>& runtimes, Doorbell* output)
    : realtime_(realtime), loop_of_(runtimes.size()) {
  std::vector<std::vector<std::size_t>> grasps;
  for (const auto& grasp : board.grasps) grasps.push_back(grasp->sensors);
  for (const auto& part : share_out(runtimes.size(), grasps, estimate_threads(realtime, runtimes.size()))) {
    running_.emplace_back().loop = std::make_unique<EstimateLoop>(board, runtimes, part, alerts, output);
    for (const std::size_t sensor : part) loop_of_[sensor] = running_.back().loop.get();
  }
}

void EstimateThreads::start(const RealtimeGrant& grant) {
  for (std::size_t i = 0; i < running_.size(); ++i) {
    const std::string name = i == 0 ? "estimate" : "estimate " + std::to_string(i + 1);
    running_[i].thread = Thread(name, kStackBytes, [this, grant, loop = running_[i].loop.get()] {
      enter_realtime(realtime_, grant);
      loop->run(stop_);
    });
  }
}

void EstimateThreads::request_stop() noexcept {
  stop_.store(true, std::memory_order_relaxed);
  ring();
}

bool EstimateThreads::join_until(std::chrono::steady_clock::time_point deadline) {
  bool ended = true;
  for (Running& each : running_) ended = each.thread.join_until(deadline) && ended;
  return ended;
}

void EstimateThreads::ring() noexcept {
  for (Running& each : running_) each.loop->ring();
}

bool EstimateThreads::all_ran() noexcept {
  bool all = true;
  for (Running& each : running_) {
    const std::uint64_t now = each.loop->heartbeat();
    all = all && now != each.heartbeat;
    each.heartbeat = now;
  }
  return all;
}

}  // namespace slipd
