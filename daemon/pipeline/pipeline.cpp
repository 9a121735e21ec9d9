#include "daemon/pipeline/pipeline.hpp"

#include <algorithm>

namespace slipd {
namespace {

constexpr std::chrono::milliseconds kMoreTime{500};  // for what can only end after the drivers have

// Puts all sensors and grasps on the board.
std::vector<std::unique_ptr<SensorRuntime>> make_runtimes(const Settings& settings, Board& board) {
  std::vector<std::unique_ptr<SensorRuntime>> runtimes;
  for (const auto& sensor : settings.sensors) {
    board.sensors.push_back(std::make_unique<SensorStatus>(sensor.setup.name, sensor.driver));
    SensorStatus& status = *board.sensors.back();
    status.stale_after_ns = std::chrono::nanoseconds(sensor.stale_after).count();
    runtimes.push_back(std::make_unique<SensorRuntime>(sensor, status));
  }
  for (const GraspSettings& grasp : settings.grasps) {
    std::vector<std::size_t> members;  // in the order of the names, which Estimate::first_member counts in
    for (const std::string& name : grasp.sensors) {
      const auto named = [&](const SensorSettings& sensor) { return sensor.setup.name == name; };
      const auto found = std::find_if(settings.sensors.begin(), settings.sensors.end(), named);
      members.push_back(
          static_cast<std::size_t>(found - settings.sensors.begin()));  // the configuration has it
    }
    board.grasps.push_back(std::make_unique<GraspStatus>(grasp.name, std::move(members), grasp.poses));
  }
  return runtimes;
}

// The indices of each device's sensors. A sensor that names no device has one of its own.
std::vector<std::vector<std::size_t>> devices_of(const std::vector<SensorSettings>& sensors) {
  std::vector<std::vector<std::size_t>> devices;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const auto same = std::find_if(devices.begin(), devices.end(), [&](const auto& device) {
      const SensorSettings& other = sensors[device.front()];
      return other.driver == sensors[i].driver && !sensors[i].setup.device.empty() &&
             other.setup.device == sensors[i].setup.device;
    });
    if (same != devices.end()) {
      same->push_back(i);
    } else {
      devices.push_back({i});
    }
  }
  return devices;
}

LogRing& new_log(Board& board) {
  return board.logs.emplace_back();
}

}  // namespace

Pipeline::Pipeline(const Settings& settings, DriverCatalogue& drivers, Board& board, ModelSource models,
                   Doorbell* output)
    : settings_(settings),
      runtimes_(make_runtimes(settings, board)),
      estimate_threads_(settings.realtime, settings.alerts, board, runtimes_, output),
      estimator_factory_(settings, runtimes_, new_log(board), estimate_threads_, std::move(models)),
      bias_store_(new_log(board), board.io_wakeup) {
  std::vector<std::string> problems;
  for (const auto& device : devices_of(settings.sensors)) {
    const SensorSettings& first = settings.sensors[device.front()];
    const std::string place = "/sensors/" + std::to_string(device.front());
    const DriverModule* module = drivers.find(first.driver);
    if (module == nullptr) {
      problems.push_back(place + "/driver = \"" + first.driver + "\": " + drivers.why_not(first.driver));
      continue;
    }
    std::vector<SensorSetup> setups;
    setups.reserve(device.size());
    for (const std::size_t sensor : device) setups.push_back(settings.sensors[sensor].setup);
    try {
      auto opened = [this](std::size_t sensor, std::shared_ptr<FrameFeed> feed) {
        estimator_factory_.request(sensor, std::move(feed));
      };
      acquirers_.push_back(std::make_unique<Acquirer>(module->create(setups), device, runtimes_, bias_store_,
                                                      new_log(board), estimate_threads_, std::move(opened)));
    } catch (const std::exception& error) {
      problems.push_back(place + " (" + first.setup.name + ", driver " + first.driver + "): " + error.what());
    }
  }
  if (!problems.empty()) throw SettingsError(std::move(problems));
}

void Pipeline::start(const RealtimeGrant& grant) {
  estimator_factory_.start();
  estimate_threads_.start(grant);
  for (auto& acquirer : acquirers_) acquirer->start(settings_.realtime, grant);
}

bool Pipeline::stop(std::chrono::steady_clock::time_point deadline) {
  const auto later = deadline + kMoreTime;
  unfinished_.clear();
  const auto note = [this](bool ended, const std::string& what) {
    if (!ended) unfinished_ += (unfinished_.empty() ? "" : ", ") + what;
  };
  for (auto& acquirer : acquirers_) acquirer->request_stop();
  estimator_factory_.request_stop();
  for (auto& acquirer : acquirers_)
    note(acquirer->join_until(deadline), "the driver of " + acquirer->sensors());
  bias_store_.request_stop();
  note(bias_store_.join_until(later), "the store of zeros");
  estimate_threads_.request_stop();
  const bool estimated = estimate_threads_.join_until(later);
  note(estimated, "an estimate thread");
  const bool set_up = estimator_factory_.join_until(later);
  note(set_up, "the set-up of an estimator");
  learning_ended_ = estimated && set_up;
  return unfinished_.empty();
}

// Drivers may hang. An acquire thread that comes back from one uses no estimator: it estimates only in its
// turn (EstimateLoop::frame_delivered), and an estimate thread ends with the turn and keeps it. What it still
// touches stays: feeds, which it shares, and the set-up's list of requests, which nobody reads.
std::vector<LearnedState> Pipeline::release_learned_state() {
  if (!learning_ended_) return {};
  return estimator_factory_.release_learned_state();
}

}  // namespace slipd
