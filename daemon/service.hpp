// The daemon as a whole: what is started, in which order, and how it ends. main calls it; it becomes the io
// thread.
#pragma once

#include "config/settings.hpp"
#include "daemon/pipeline/modules.hpp"

namespace slipd {

// What drivers refuse although the schemas allow it. Throws SettingsError; touches no device.
void check_drivers(const Settings& settings, DriverModules& drivers);

// Serves until SIGTERM or SIGINT; the exit code. Throws SettingsError for what drivers refuse in the
// configuration, and std::runtime_error for what keeps it from starting. Does not return if a driver hangs:
// then it ends the process itself.
int serve(const Settings& settings, DriverModules& drivers);

}  // namespace slipd
