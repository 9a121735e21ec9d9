// slipd's command line. Exit code 0: done or stopped; 1: failed; 2: wrong use or configuration.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/pipeline/modules.hpp"
#include "daemon/service.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kWrongUse = 2;

using nlohmann::json;

// What an option accepts, as far as its schema says: "number, kPa, 0 to 10, default 1".
std::string form_of(const json& option) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  const auto plain = [](const json& value) {
    return value.is_string() ? value.get<std::string>() : value.dump();
  };
  if (option.contains("type")) add(plain(option["type"]));
  if (option.contains("enum")) {
    std::string choices;
    for (const json& choice : option["enum"]) choices += (choices.empty() ? "" : " | ") + plain(choice);
    add(choices);
  }
  if (option.contains("unit")) add(plain(option["unit"]));
  const bool from = option.contains("minimum");
  const bool to = option.contains("maximum");
  if (from && to) add(plain(option["minimum"]) + " to " + plain(option["maximum"]));
  if (from && !to) add("at least " + plain(option["minimum"]));
  if (to && !from) add("at most " + plain(option["maximum"]));
  if (option.contains("default")) add("default " + option["default"].dump());
  return text;
}

void print_option(const std::string& key, const json& option, std::ostream& out) {
  const std::string form = form_of(option);
  out << "    " << key << (form.empty() ? "" : " (" + form + ")");
  if (option.contains("description")) out << ": " << option["description"].get<std::string>();
  out << '\n';
}

// slipd --list-drivers: every module, what it is for, and its options and keys of `device` from its own
// schema. False if a module cannot be used; the reason is printed in its place.
bool list_drivers(slipd::DriverModules& drivers, std::ostream& out) {
  bool all_well = true;
  const auto names = drivers.names();
  out << names.size() << " driver" << (names.size() == 1 ? "" : "s") << " in " << drivers.folder().string()
      << '\n';
  for (const std::string& name : names) {
    const slipd::DriverModule* module = drivers.find(name);
    if (module == nullptr) {
      all_well = false;
      out << "  " << name << ": cannot be used: " << drivers.why_not(name) << '\n';
      continue;
    }
    out << "  " << name << ": " << module->summary << '\n';
    const json schema = json::parse(module->options_schema, nullptr, false);
    const auto print_all = [&](const char* properties, const std::string& prefix) {
      const json::json_pointer at(properties);
      if (!schema.contains(at)) return;
      for (const auto& [key, option] : schema[at].items()) print_option(prefix + key, option, out);
    };
    print_all("/properties", "");
    print_all("/$defs/device/properties", "device.");
  }
  return all_well;
}

// Runs the service, or only checks the configuration.
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
  CLI::App app{"Tells for every tactile frame how close the held object is to slipping.", "slipd"};
  std::string config;
  std::string driver_dir;
  bool check = false;
  bool list = false;
  auto* const config_option = app.add_option("--config", config, "Configuration (JSON with comments)");
  app.add_flag("--check-config", check, "Say what is wrong with the configuration, and end")
      ->needs(config_option);
  app.add_flag("--list-drivers", list, "List the drivers and their options, and end");
  app.add_option("--driver-dir", driver_dir, "Folder of the driver modules")->check(CLI::ExistingDirectory);
  app.set_version_flag("--version", std::string("slipd ") + SLIPD_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUse;
  }

  slipd::DriverModules drivers(driver_dir.empty() ? std::nullopt
                                                  : std::optional<std::filesystem::path>(driver_dir));
  if (list) return list_drivers(drivers, std::cout) ? 0 : kFailed;
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
