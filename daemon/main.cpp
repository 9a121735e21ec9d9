// slipd's command line. Exit 0: done or stopped; 1: it failed; 2: wrong use or configuration.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>

#include "daemon/driver_list.hpp"
#include "daemon/service.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kWrongUse = 2;

// Serves, or only says whether it would.
int use(const std::string& config, slipd::DriverModules& drivers, bool only_check) {
  try {
    if (!only_check) return slipd::serve(config, drivers);
    const slipd::Settings settings = slipd::check_configuration(config, drivers);
    for (const std::string& note : slipd::notes_on(settings)) std::cerr << "note: " << note << '\n';
    const std::size_t sensors = settings.sensors.size();
    std::cout << config << ": fine: " << sensors << " sensor" << (sensors == 1 ? "" : "s") << '\n';
    return 0;
  } catch (const slipd::SettingsError& error) {
    for (const std::string& problem : error.problems()) std::cerr << problem << '\n';
    return kWrongUse;
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
  return use(config, drivers, check);
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
