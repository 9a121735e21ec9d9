#include "bridges/support/program.hpp"

#include <systemd/sd-daemon.h>

#include <CLI/CLI.hpp>
#include <cinttypes>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>

#include "bridges/support/clock.hpp"
#include "bridges/support/log.hpp"

namespace slipd::bridges {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUse = 2;

struct CommandLine {
  std::string config;
  bool only_check = false;
  std::map<std::string, std::string> overrides;  // by key
};

// An exit code: the command line is wrong, or asked for no service. Negative: go on.
int parse(const Program& program, int argc, char** argv, CommandLine& out) {
  CLI::App app{program.summary, program.name};
  app.add_option("--config", out.config, "Settings (JSON with comments)")->required();
  app.add_flag("--check-config", out.only_check, "Say what is wrong with the settings, and end");
  for (const Override& one : program.overrides) app.add_option(one.option, out.overrides[one.key], one.help);
  app.set_version_flag("--version", std::string(program.name) + " " + SLIPD_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUse;
  }
  return -1;
}

// Of the file, with what the command line sets. Throws as load_settings does.
nlohmann::json settings_of(const Program& program, const CommandLine& line) {
  nlohmann::json settings = load_settings(line.config, program.schema, program.further);
  for (const auto& [key, text] : line.overrides) {
    if (!text.empty()) settings[key] = text;
  }
  return settings;
}

void tell_reloading() {
  constexpr std::int64_t kNsPerUs = 1000;
  sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%" PRId64, monotonic_ns() / kNsPerUs);
}

// SIGHUP: the service of the file as it is now. Settings with an error change nothing.
void reload(const Program& program, const CommandLine& line, const MakeService& make, Loop& loop,
            std::unique_ptr<Service>& service) {
  tell_reloading();
  try {
    const nlohmann::json settings = settings_of(program, line);
    service.reset();  // before the new one, which may need the same port
    service = make(settings, loop);
    log(LogLevel::notice, "read " + line.config + " again");
  } catch (const SettingsError& error) {
    for (const std::string& problem : error.problems()) log(LogLevel::error, problem);
    log(LogLevel::error, "the settings stay as they were");
  }
  sd_notify(0, "READY=1");
}

int serve(const Program& program, const CommandLine& line, const nlohmann::json& settings,
          const MakeService& make) {
  std::signal(SIGPIPE, SIG_IGN);  // a peer that goes is an error of write()
  Loop loop;
  std::unique_ptr<Service> service;
  for (const int number : {SIGTERM, SIGINT}) loop.on_signal(number, [&] { loop.stop(); });
  loop.on_signal(SIGHUP, [&] { reload(program, line, make, loop, service); });
  service = make(settings, loop);
  sd_notify(0, "READY=1");
  loop.run();
  sd_notify(0, "STOPPING=1");
  service.reset();
  return 0;
}

}  // namespace

int run_program(const Program& program, int argc, char** argv, const MakeService& make) {
  CommandLine line;
  if (const int code = parse(program, argc, argv, line); code >= 0) return code;
  try {
    const nlohmann::json settings = settings_of(program, line);
    if (!line.only_check) return serve(program, line, settings, make);
    std::cout << line.config << ": fine\n";
    return 0;
  } catch (const SettingsError& error) {
    for (const std::string& problem : error.problems()) log(LogLevel::error, problem);
    return kWrongUse;
  } catch (const std::exception& error) {
    log(LogLevel::error, std::string(program.name) + ": " + error.what());
    return kFailed;
  }
}

}  // namespace slipd::bridges
