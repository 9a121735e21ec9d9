#include "daemon/engine.hpp"

#include <algorithm>
#include <utility>

namespace slipd {

Engine::Engine(Settings settings, DriverCatalogue& drivers)
    : settings_(std::move(settings)),
      models_(trainer_beside_program()),
      pipeline_(
          settings_, drivers, board_,
          [this](const std::string& sensor, const ChainSetup& setup) { return models_.get(sensor, setup); },
          settings_.can ? &output_bell_ : nullptr),
      context_{.settings = settings_,
               .board = board_,
               .realtime = {},
               .ring_estimate = [this] { pipeline_.ring(); },
               .flight = nullptr,
               .latency_last_minute = {},
               .rates_hz = {},
               .repeats_hz = {},
               .can = nullptr} {
  if (settings_.recorder.seconds > 0) flight_ = std::make_unique<FlightRecorder>(settings_.recorder, board_);
  context_.flight = flight_.get();
  if (settings_.can) context_.can = &can_.emplace(settings_, board_, output_bell_).report();
}

void Engine::start(const RealtimeGrant& grant) {
  context_.realtime = grant;
  if (flight_) flight_->start();
  pipeline_.start(grant);
  if (can_) can_->start(grant);
}

bool Engine::stop(std::chrono::steady_clock::time_point deadline) {
  models_.stop();
  // Before all that is waited for, so that the disk has as long as they together. Alerts come to it by the
  // server, which has ended.
  if (flight_) flight_->request_stop();
  // CAN first, so that receivers learn at once that no estimate holds any more.
  const bool can_stopped = !can_ || can_->stop(deadline);
  pipeline_.stop(deadline);
  unfinished_ = pipeline_.unfinished();
  board_.shared.close();
  const auto note = [this](bool ended, const char* what) {
    if (!ended) unfinished_ += (unfinished_.empty() ? "" : ", ") + std::string(what);
  };
  note(can_stopped, "the CAN output");
  const bool recorded = !flight_ || flight_->join_until(deadline);
  note(recorded, "the flight recorder");
  // Its histories are freed here, because a driver that hangs keeps the engine for good. An acquire thread
  // that comes back does not find them: the recorder's thread has detached its queues. Others that would look
  // for it are the server and its clients' requests, which have ended.
  if (recorded) {
    context_.flight = nullptr;
    flight_.reset();
  }
  return unfinished_.empty();
}

void Engine::adopt_alerts(const Board& before) {
  for (const auto& old : before.sensors) {
    const Estimate last = old->latest.load().estimate;
    const auto same = std::ranges::find(board_.sensors, old->name, &SensorStatus::name);
    if (same == board_.sensors.end() || !is_raised(last.alert)) continue;
    Published stands;
    stands.estimate.alert = last.alert;
    stands.estimate.alert_cause = last.alert_cause;
    (*same)->latest.store(stands);
  }
}

bool Engine::all_devices_tried() const {
  return std::none_of(board_.sensors.begin(), board_.sensors.end(), [](const auto& status) {
    return status->link.load(std::memory_order_relaxed) == DeviceLink::opening;
  });
}

}  // namespace slipd
