#include "daemon/service.hpp"

#include <unistd.h>

#include <algorithm>
#include <asio/io_context.hpp>
#include <asio/signal_set.hpp>
#include <asio/steady_timer.hpp>
#include <csignal>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/chain/chain_parts.hpp"
#include "daemon/engine.hpp"
#include "daemon/log/log.hpp"
#include "daemon/notify.hpp"
#include "daemon/paper_loader.hpp"
#include "daemon/pipeline/estimator_factory.hpp"
#include "daemon/rpc/clients/socket_file.hpp"
#include "daemon/rpc/server.hpp"
#include "daemon/telemetry/metrics_file.hpp"
#include "schema/schema.hpp"

namespace slipd {
namespace {

using namespace std::chrono_literals;

constexpr auto kLogInterval = 20ms;    // between two looks at the log rings
constexpr auto kStatusInterval = 1s;   // between two updates of systemctl status
constexpr auto kStopTimeout = 1s;      // for threads to end; a stop may take two seconds in all
constexpr auto kReadyTimeout = 3s;     // for devices to open before slipd reports ready
constexpr int kFatal = 1;              // exit code
constexpr auto kReadyInterval = 10ms;  // between two looks at the devices

RealtimeGrant realtime_or_throw(const RealtimeSettings& settings) {
  RealtimeGrant grant = request_realtime(settings);
  if (grant.refusal.empty()) return grant;
  if (settings.mode == RealtimeMode::enforce) {
    throw std::runtime_error("realtime.mode is \"enforce\", but the system refuses " + grant.refusal);
  }
  write_log(LogLevel::warning, {{}, Cause::configuration}, "real time: not granted: " + grant.refusal);
  return grant;
}

// As far as the settings alone say: a device may know its layout or class better.
ChainSetup chain_setup_of(const Settings& settings, const SensorSettings& sensor) {
  return {.layout = sensor.setup.layout,
          .scene = settings.scene_of(sensor),
          .estimator = settings.estimator,
          .alerts = settings.alerts,
          .friction = sensor.friction};
}

// As the configuration writes it.
std::string name_of(MethodChoice method) {
  const auto& choices = method_choices();
  return std::ranges::find(choices, method, [](const auto& choice) { return choice.second; })->first;
}

// A sensor's trained method that is not installed is a mistake of the configuration, as a driver is.
std::string why_no_trained_method(const Settings& settings) {
  const bool needed = std::ranges::any_of(settings.sensors, [&](const SensorSettings& sensor) {
    return needs_model(chain_setup_of(settings, sensor));
  });
  if (!needed) return {};
  try {
    paper_module();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

// Judges what the configuration names outside of it. Prefixes the drivers' problems with the file's name.
std::unique_ptr<Engine> make_engine(Settings settings, DriverModules& drivers, const std::string& file) {
  if (const auto& metrics = settings.metrics.file; !metrics.empty()) {
    if (const std::string why = why_no_metrics_file(metrics); !why.empty())
      throw SettingsError({problem_of("/metrics/file", metrics.string(), why).in(file)});
  }
  if (const std::string why = why_no_trained_method(settings); !why.empty())
    throw SettingsError({problem_of("/estimator/method", name_of(settings.estimator.method), why).in(file)});
  try {
    return std::make_unique<Engine>(std::move(settings), drivers);
  } catch (const SettingsError& error) {
    std::vector<std::string> problems = error.problems();
    for (std::string& problem : problems) problem.insert(0, file + ": ");
    throw SettingsError(std::move(problems));
  }
}

std::unique_ptr<SocketFile> socket_for(const SocketSettings& settings) {
  if (const auto passed = notify::passed_socket()) return std::make_unique<SocketFile>(*passed);
  return std::make_unique<SocketFile>(settings.path, settings.mode);
}

// Keeps the settings that only a restart can change, and warns if they differ.
void retain_restart_only_settings(Settings& next, const Settings& now) {
  const auto keep = [](auto& value, const auto& was, const char* name) {
    if (value != was)
      write_log(LogLevel::warning, {{}, Cause::configuration},
                std::string("reload: ") + name + " is taken up by a restart only");
    value = was;
  };
  keep(next.socket.path, now.socket.path, "socket.path");
  keep(next.socket.mode, now.socket.mode, "socket.mode");
  keep(next.realtime, now.realtime, "realtime");
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
      try {
        body_();
      } catch (const std::bad_alloc&) {  // the next tick tries again
      }
      wait();
    });
  }
  asio::steady_timer timer_;
  std::chrono::microseconds interval_;
  std::function<void()> body_;
};

class Service {
 public:
  Service(std::string config_file, DriverModules& drivers)
      : config_file_(std::move(config_file)),
        drivers_(drivers),
        signals_(io_, SIGTERM, SIGINT, SIGHUP),
        ready_timer_(io_),
        recorder_(io_),
        engine_(make_engine(load_settings(config_file_, drivers), drivers, config_file_)) {
    set_up_log(engine_->settings().log_level);
    file_ = socket_for(engine_->settings().socket);
  }

  int run();

 private:
  void begin();
  void on_signals();
  void reload();
  std::unique_ptr<Engine> next_engine();
  void switch_to(std::unique_ptr<Engine> next);
  void report_ready_when_tried();
  void feed_watchdog();
  int end(int code);

  const std::string config_file_;
  DriverModules& drivers_;
  asio::io_context io_{1};
  asio::signal_set signals_;
  asio::steady_timer ready_timer_;
  std::chrono::steady_clock::time_point ready_at_latest_;
  Clients clients_{io_};
  Recorder recorder_;
  std::unique_ptr<Engine> engine_;
  std::vector<std::unique_ptr<Engine>> abandoned_;  // one of their threads hangs, so they are never destroyed
  std::unique_ptr<SocketFile> file_;
  std::optional<Server> server_;
  LogLimit log_limit_;
  std::string status_;
};

int Service::run() {
  std::signal(SIGPIPE, SIG_IGN);
  const RealtimeGrant grant = realtime_or_throw(engine_->settings().realtime);
  engine_->context().realtime = grant;
  begin();
  on_signals();
  const Ticker logs(io_, kLogInterval, [this] { drain_logs(engine_->board().logs, log_limit_); });
  const Ticker status(io_, kStatusInterval, [this] { notify::status(engine_->context(), status_); });
  std::optional<Ticker> watchdog;
  if (const auto timeout = notify::watchdog_timeout())
    watchdog.emplace(io_, *timeout / 2, [this] { feed_watchdog(); });
  const std::size_t sensors = engine_->settings().sensors.size();
  write_log(LogLevel::info, {},
            "slipd " SLIPD_VERSION " serves " + std::to_string(sensors) +
                (sensors == 1 ? " sensor" : " sensors") + " on " + file_->name());
  ready_at_latest_ = std::chrono::steady_clock::now() + kReadyTimeout;
  report_ready_when_tried();
  try {
    io_.run();
  } catch (const std::exception& error) {
    // A pending asynchronous wait may be lost with the exception. The service manager restarts slipd.
    write_log(LogLevel::error, {{}, Cause::machine}, std::string("slipd cannot go on: ") + error.what());
    return end(kFatal);
  }
  return end(0);
}

void Service::begin() {
  server_.emplace(io_, engine_->context(), clients_, recorder_, file_->duplicate());
  engine_->start(engine_->context().realtime);
}

void Service::on_signals() {
  signals_.async_wait([this](const std::error_code& error, int signal) {
    if (error) return;
    if (signal == SIGHUP) {
      reload();
      return on_signals();
    }
    write_log(LogLevel::info, {}, signal == SIGTERM ? "stopping on SIGTERM" : "stopping on SIGINT");
    io_.stop();
  });
}

// slipd is ready when the socket answers and the first attempt to open each device has ended, or after
// kReadyTimeout.
void Service::report_ready_when_tried() {
  if (engine_->all_devices_tried() || std::chrono::steady_clock::now() >= ready_at_latest_) {
    notify::status(engine_->context(), status_);
    return notify::ready();
  }
  ready_timer_.expires_after(kReadyInterval);
  ready_timer_.async_wait([this](const std::error_code& error) {
    if (!error) report_ready_when_tried();
  });
}

// Sent only while all estimate threads run. That io runs is shown by this call.
void Service::feed_watchdog() {
  if (engine_->all_ran()) notify::watchdog();
}

void Service::reload() {
  notify::reloading();
  if (auto next = next_engine()) {
    switch_to(std::move(next));
    change_log_level(engine_->settings().log_level);
    write_log(LogLevel::info, {}, "reload: the new configuration is in force");
  } else {
    write_log(LogLevel::error, {{}, Cause::configuration}, "reload: the configuration in force stays");
  }
  ready_at_latest_ = std::chrono::steady_clock::now() + kReadyTimeout;
  report_ready_when_tried();
}

// An engine of the present configuration file; null if it cannot be used, which is logged.
std::unique_ptr<Engine> Service::next_engine() {
  try {
    drivers_.forget_absent();
    Settings settings = load_settings(config_file_, drivers_);
    retain_restart_only_settings(settings, engine_->settings());
    return make_engine(std::move(settings), drivers_, config_file_);
  } catch (const SettingsError& error) {
    for (const std::string& problem : error.problems())
      write_log(LogLevel::error, {{}, Cause::configuration}, "reload: " + problem);
  } catch (const std::exception& error) {
    write_log(LogLevel::error, {{}, Cause::configuration}, std::string("reload: ") + error.what());
  }
  return nullptr;
}

// Closes the old devices before the new ones are opened, because they may be the same.
void Service::switch_to(std::unique_ptr<Engine> next) {
  next->context().realtime = engine_->context().realtime;
  next->context().started = engine_->context().started;
  next->context().recordings = engine_->context().recordings;
  recorder_.end_all();
  server_.reset();
  const bool clean = engine_->stop(std::chrono::steady_clock::now() + kStopTimeout);
  drain_logs(engine_->board().logs, log_limit_);
  std::swap(engine_, next);
  log_limit_ = {};
  engine_->adopt_alerts(next->board());
  engine_->adopt_learned_state(next->release_learned_state());
  if (!clean) {
    write_log(LogLevel::error, {{}, Cause::none},
              "reload: " + next->unfinished() + " of the old configuration does not end, and is left behind");
    abandoned_.push_back(std::move(next));
  }
  begin();
}

// Returns the process's exit code, or ends it with that code if a thread does not end.
int Service::end(int code) {
  notify::stopping();
  const auto deadline = std::chrono::steady_clock::now() + kStopTimeout;
  server_.reset();
  recorder_.end_all();
  clients_.close_all();
  file_.reset();
  const bool clean = engine_->stop(deadline) && abandoned_.empty();
  drain_logs(engine_->board().logs, log_limit_);
  if (!clean) {
    const std::string& unfinished = engine_->unfinished();
    write_log(LogLevel::error, {{}, Cause::none},
              (unfinished.empty() ? "what an earlier reload left behind" : unfinished) +
                  " does not end; the process ends without it");
    _exit(code);  // its thread may use anything that a destructor would free
  }
  return code;
}

// Judges sensors that are known without their device: simulated ones and recordings. Opening a recording
// touches no device, and compares its columns with the sensor's layout. One that is not there yet is no
// mistake of the configuration. Throws SettingsError.
void check_sensors(const Settings& settings, DriverModules& drivers, const std::string& name) {
  std::vector<std::string> problems;
  for (std::size_t i = 0; i < settings.sensors.size(); ++i) {
    const SensorSettings& sensor = settings.sensors[i];
    ChainSetup setup = chain_setup_of(settings, sensor);
    if (sensor.driver == "replay") {
      std::error_code unknown;
      if (!std::filesystem::exists(sensor.setup.options.value("file", ""), unknown)) continue;
      try {
        const DeviceInfo info = drivers.find(sensor.driver)->create({sensor.setup})->open();
        setup.sensor_class = info.sensors.front().sensor_class;
      } catch (const DriverError& error) {
        problems.push_back(name + ": /sensors/" + std::to_string(i) + "/options: " + error.what());
        continue;
      }
    } else if (sensor.driver != "sim") {
      continue;
    }
    if (const std::string why = why_method_cannot_read(setup); !why.empty())
      problems.push_back(problem_of("/estimator/method", name_of(settings.estimator.method),
                                    "sensor \"" + sensor.setup.name + "\": " + why)
                             .in(name));
  }
  if (!problems.empty()) throw SettingsError(std::move(problems));
}

// What check_sensors cannot refuse, because the device says what it measures. A profile brings the layout,
// so that with one nothing is known.
std::string why_method_may_not_read(const Settings& settings, const SensorSettings& sensor) {
  if (!sensor.setup.profile.empty() || sensor.driver == "sim" || sensor.driver == "replay") return {};
  const std::string why = why_method_cannot_read(chain_setup_of(settings, sensor));
  return why.empty() ? why : "it gets no estimate if its device measures shear: " + why;
}

}  // namespace

Settings check_configuration(const std::string& file, DriverModules& drivers) {
  Settings settings = load_settings(file, drivers);
  check_sensors(settings, drivers, file);
  return make_engine(std::move(settings), drivers, file)->settings();
}

std::vector<std::string> notes_on(const Settings& settings) {
  std::vector<std::string> notes;
  for (const auto& sensor : settings.sensors) {
    for (const std::string& why : {why_method_is_replaced(chain_setup_of(settings, sensor)),
                                   why_method_may_not_read(settings, sensor)}) {
      if (!why.empty()) notes.push_back(sensor.setup.name + ": " + why);
    }
  }
  return notes;
}

int serve(const std::string& config_file, DriverModules& drivers) {
  return Service(config_file, drivers).run();
}

}  // namespace slipd
