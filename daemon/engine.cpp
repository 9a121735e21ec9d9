#include "daemon/engine.hpp"

#include <algorithm>
#include <utility>

namespace slipd {

Engine::Engine(Settings settings, DriverCatalogue& drivers)
    : settings_(std::move(settings)),
      models_(trainer_beside_program()),
      pipeline_(
          settings_, drivers, board_,
          [this](const std::string& sensor, const ChainSetup& setup) { return models_.get(sensor, setup); }),
      world_{.settings = settings_,
             .board = board_,
             .realtime = {},
             .ring_estimate = [this] { pipeline_.ring(); },
             .flight = nullptr,
             .last_minute = {},
             .rates_hz = {}} {
  if (settings_.recorder.seconds > 0) flight_ = std::make_unique<FlightRecorder>(settings_.recorder, board_);
  world_.flight = flight_.get();
}

void Engine::start(const RealtimeGrant& grant) {
  world_.realtime = grant;
  if (flight_) flight_->start();
  pipeline_.start(grant);
}

bool Engine::stop(std::chrono::system_clock::time_point deadline) {
  models_.stop();
  return pipeline_.stop(deadline);
}

bool Engine::tried() const {
  return std::none_of(board_.sensors.begin(), board_.sensors.end(), [](const auto& panel) {
    return panel->link.load(std::memory_order_relaxed) == Link::opening;
  });
}

}  // namespace slipd
