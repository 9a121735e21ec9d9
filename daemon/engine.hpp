// One configuration in use: its drivers, threads and board. A reload makes a second engine and stops the
// first when the second was made without error.
#pragma once

#include <optional>
#include <string>

#include "daemon/can/output.hpp"
#include "daemon/model_provider.hpp"
#include "daemon/pipeline/pipeline.hpp"
#include "daemon/record/flight_recorder.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

// Not thread-safe. Called from one thread: io.
class Engine {
 public:
  // Makes the drivers. Starts no thread, touches no device. `drivers` outlives it. Throws SettingsError for
  // what drivers refuse, and std::runtime_error if the flight recorder has no folder.
  Engine(Settings settings, DriverCatalogue& drivers);
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  // Starts all threads. Once.
  void start(const RealtimeGrant& grant);

  // Stops all threads by about `deadline`, after the server ended. False: a driver or the disk hangs, and
  // this engine must not be destroyed.
  bool stop(std::chrono::steady_clock::time_point deadline);
  // What had not ended when stop() returned, for people; empty: all had.
  const std::string& unfinished() const noexcept { return unfinished_; }

  // adopt_learned_state before start, release_learned_state after stop, also if a driver hangs: hand what
  // estimators have learned to the next engine.
  void adopt_learned_state(std::vector<LearnedState> learned) {
    pipeline_.adopt_learned_state(std::move(learned));
  }
  std::vector<LearnedState> release_learned_state() { return pipeline_.release_learned_state(); }

  // Before start. Raised alerts of the configuration before, whose board this is, stand for sensors of the
  // same name, whatever else of them changed, until their frames say otherwise.
  void adopt_alerts(const Board& before);

  // Whether the first attempt to open each device has ended.
  bool all_devices_tried() const;
  // Whether each estimate thread has run since the last call, which was at least a quarter of a second ago.
  bool all_ran() noexcept { return pipeline_.all_ran(); }

  const Settings& settings() const noexcept { return settings_; }
  Board& board() noexcept { return board_; }
  ServiceContext& context() noexcept { return context_; }

 private:
  const Settings settings_;
  Board board_;
  std::unique_ptr<FlightRecorder> flight_;  // null: recorder.seconds is 0, or it was stopped
  ModelProvider models_;
  Doorbell output_bell_;
  std::optional<can::Output> can_;
  Pipeline pipeline_;
  ServiceContext context_;
  std::string unfinished_;
};

}  // namespace slipd
