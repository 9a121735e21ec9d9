// The service: start, event loop, reload and stop. main calls it; its thread becomes the io thread.
#pragma once

#include <string>
#include <vector>

#include "config/settings.hpp"
#include "daemon/pipeline/modules.hpp"

namespace slipd {

// The settings of a configuration file, after its drivers were made. Touches no device. Throws SettingsError.
Settings check_configuration(const std::string& file, DriverModules& drivers);

// What the file asks for and slipd does otherwise, one line each, as far as it is known without devices.
std::vector<std::string> notes_on(const Settings& settings);

// Runs the service until SIGTERM or SIGINT and returns the exit code. On SIGHUP it reloads the file; if that
// cannot be used, the present configuration stays. Throws SettingsError for a configuration that cannot be
// used at start, and std::runtime_error if it cannot start otherwise. Does not return if a driver hangs at
// the end: it calls _exit.
int serve(const std::string& config_file, DriverModules& drivers);

}  // namespace slipd
