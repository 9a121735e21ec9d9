// slipd's command line. Exit 0: done or stopped; 1: it failed; 2: wrong use or configuration.
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>

#include "daemon/driver_list.hpp"
#include "daemon/log.hpp"
#include "daemon/service.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kWrongUse = 2;

int print_problems(const slipd::SettingsError& error, const std::string& before = "") {
  for (const std::string& problem : error.problems()) std::cerr << before << problem << '\n';
  return kWrongUse;
}

// Serves, or only says whether it would.
int use(const slipd::Settings& settings, slipd::DriverModules& drivers, const std::string& config,
        bool only_check) {
  try {
    if (only_check) {
      slipd::check_drivers(settings, drivers);
      std::cout << config << ": fine: " << settings.sensors.size() << " sensor"
                << (settings.sensors.size() == 1 ? "" : "s") << '\n';
      return 0;
    }
    slipd::set_up_log(settings.log_level);
    return slipd::serve(settings, drivers);
  } catch (const slipd::SettingsError& error) {
    return print_problems(error, config + ": ");
  }
}

int run(int argc, char** argv) {
  CLI::App app{"slipd tells for every tactile frame how close a gripper's object is to slipping.", "slipd"};
  std::string config;
  std::string driver_dir;
  bool check = false;
  bool list = false;
  auto* const config_option = app.add_option("--config", config, "Configuration (JSON with comments)");
  app.add_flag("--check-config", check, "Say what is wrong with the configuration, and end")
      ->needs(config_option);
  app.add_flag("--list-drivers", list, "Say what drivers there are and what options they take, and end");
  app.add_option("--driver-dir", driver_dir, "Folder of the driver modules")->check(CLI::ExistingDirectory);
  app.set_version_flag("--version", std::string("slipd ") + SLIPD_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUse;
  }

  slipd::DriverModules drivers(driver_dir.empty() ? std::nullopt
                                                  : std::optional<std::filesystem::path>(driver_dir));
  if (list) return slipd::list_drivers(drivers, std::cout) ? 0 : kFailed;
  if (config.empty()) {
    std::cerr << "slipd: --config FILE is missing; slipd --help says more\n";
    return kWrongUse;
  }
  try {
    return use(slipd::load_settings(config, drivers), drivers, config, check);
  } catch (const slipd::SettingsError& error) {
    return print_problems(error);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "slipd: " << error.what() << '\n';
    return kFailed;
  }
}
