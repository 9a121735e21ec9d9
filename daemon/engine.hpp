// One configuration at work: its drivers, its threads, its board. A reload makes the next one beside it, and
// only when that is known to be good takes this one down. io thread.
#pragma once

#include <optional>

#include "daemon/can/output.hpp"
#include "daemon/model_provider.hpp"
#include "daemon/pipeline/pipeline.hpp"
#include "daemon/record/flight_recorder.hpp"
#include "daemon/telemetry/service_context.hpp"

namespace slipd {

class Engine {
 public:
  // Makes the drivers, starts nothing, touches no device. Throws SettingsError for what drivers refuse, and
  // std::runtime_error if the flight recorder is wanted but has no place to write to.
  Engine(Settings settings, DriverCatalogue& drivers);
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  void start(const RealtimeGrant& grant);

  // Ends its threads by `deadline`. False: a driver hangs, so that nothing of this may be destroyed any more.
  bool stop(std::chrono::steady_clock::time_point deadline);

  // Before start: what the engine before had learnt, from its give_up after a stop that was true.
  void inherit(std::vector<LearnedState> learned) { pipeline_.inherit(std::move(learned)); }
  std::vector<LearnedState> give_up() { return pipeline_.give_up(); }

  // Whether each device has been tried: opened, refused or found absent.
  bool tried() const;
  std::uint64_t heartbeat() const noexcept { return pipeline_.heartbeat(); }

  const Settings& settings() const noexcept { return settings_; }
  Board& board() noexcept { return board_; }
  ServiceContext& context() noexcept { return context_; }

 private:
  const Settings settings_;
  Board board_;
  std::unique_ptr<FlightRecorder> flight_;  // null: off
  ModelProvider models_;
  Doorbell output_bell_;
  std::optional<can::Output> can_;
  Pipeline pipeline_;
  ServiceContext context_;
};

}  // namespace slipd
