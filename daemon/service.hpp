// The daemon as a whole: what is started, in which order, how its configuration is exchanged, and how it
// ends. main calls it; it becomes the io thread.
#pragma once

#include <string>
#include <vector>

#include "config/settings.hpp"
#include "daemon/pipeline/modules.hpp"

namespace slipd {

// What the file says, if slipd could work with it; else throws SettingsError. Touches no device.
Settings check_configuration(const std::string& file, DriverModules& drivers);

// What the file asks for and slipd does otherwise, a line each, as far as it shows without the devices.
std::vector<std::string> notes_on(const Settings& settings);

// Serves until SIGTERM or SIGINT; the exit code. On SIGHUP it takes up what the file then says, or keeps what
// it has if that is no good. Throws SettingsError for a bad configuration at start, and std::runtime_error
// for what keeps it from starting. Does not return if a driver hangs: then it ends the process itself.
int serve(const std::string& config_file, DriverModules& drivers);

}  // namespace slipd
