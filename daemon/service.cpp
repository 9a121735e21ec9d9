#include "daemon/service.hpp"

#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <asio/io_context.hpp>
#include <asio/signal_set.hpp>
#include <asio/steady_timer.hpp>
#include <csignal>
#include <functional>
#include <optional>

#include "daemon/log.hpp"
#include "daemon/models.hpp"
#include "daemon/pipeline/pipeline.hpp"
#include "daemon/serve/server.hpp"

namespace slipd {
namespace {

using namespace std::chrono_literals;

constexpr auto kLogInterval = 20ms;  // how long a real-time thread's line may wait to be printed
constexpr auto kStopPatience = 1s;   // for drivers that hang, of the two seconds that a stop may take

RealtimeGrant realtime_or_throw(const RealtimeSettings& settings) {
  RealtimeGrant grant = ask_for_realtime(settings);
  if (grant.refusal.empty()) return grant;
  if (settings.mode == RealtimeMode::enforce) {
    throw std::runtime_error("realtime.mode is \"enforce\", but the system refuses " + grant.refusal);
  }
  spdlog::warn("real time: not granted: {}", grant.refusal);
  return grant;
}

// Calls `body` every `interval`, in the io thread, until it is destroyed.
class Ticker {
 public:
  Ticker(asio::io_context& io, std::chrono::microseconds interval, std::function<void()> body)
      : timer_(io), interval_(interval), body_(std::move(body)) {
    wait();
  }

 private:
  void wait() {
    timer_.expires_after(interval_);
    timer_.async_wait([this](const std::error_code& error) {
      if (error) return;
      body_();
      wait();
    });
  }
  asio::steady_timer timer_;
  std::chrono::microseconds interval_;
  std::function<void()> body_;
};

// Feeds systemd's watchdog at half its time, as long as the estimate thread goes round; io proves itself by
// being here.
std::optional<Ticker> watchdog(asio::io_context& io, const Pipeline& pipeline) {
  std::uint64_t interval_us = 0;
  if (sd_watchdog_enabled(0, &interval_us) <= 0) return std::nullopt;
  return std::optional<Ticker>(std::in_place, io, std::chrono::microseconds(interval_us / 2),
                               [&pipeline, last = std::uint64_t{0}]() mutable {
                                 const std::uint64_t now = pipeline.heartbeat();
                                 if (now != last) sd_notify(0, "WATCHDOG=1");
                                 last = now;
                               });
}

}  // namespace

void check_drivers(const Settings& settings, DriverModules& drivers) {
  Board board;
  const Pipeline never_started(settings, drivers, board, {});
}

int serve(const Settings& settings, DriverModules& drivers) {
  asio::io_context io(1);
  asio::signal_set signals(io, SIGTERM, SIGINT);
  std::signal(SIGPIPE, SIG_IGN);

  Board board;
  Models models(trainer_beside_program());
  Pipeline pipeline(settings, drivers, board, [&](const std::string& sensor, const ChainSetup& setup) {
    return models.get(sensor, setup);
  });
  World world{.settings = settings,
              .board = board,
              .realtime = {},
              .ring_estimate = [&] { pipeline.ring(); },
              .rates_hz = {}};
  std::optional<Server> server(std::in_place, io, world);
  world.realtime = realtime_or_throw(settings.realtime);
  pipeline.start(world.realtime);

  signals.async_wait([&](const std::error_code& error, int signal) {
    if (error) return;
    spdlog::info("stopping on {}", signal == SIGTERM ? "SIGTERM" : "SIGINT");
    io.stop();
  });
  const Ticker logs(io, kLogInterval, [&] { drain_logs(board); });
  const auto dog = watchdog(io, pipeline);
  spdlog::info("slipd {} serves {} sensor{} on {}", SLIPD_VERSION, settings.sensors.size(),
               settings.sensors.size() == 1 ? "" : "s", settings.socket.path.string());
  sd_notify(0, "READY=1");
  io.run();

  sd_notify(0, "STOPPING=1");
  const auto deadline = std::chrono::system_clock::now() + kStopPatience;
  models.stop();
  server.reset();
  const bool clean = pipeline.stop(deadline);
  drain_logs(board);
  if (!clean) {
    spdlog::error("a driver hangs and is left behind; the process ends without it");
    spdlog::shutdown();
    _exit(0);  // its thread may touch anything that a destructor would take away
  }
  return 0;
}

}  // namespace slipd
