// slipctl probe: lists the devices present and the profiles that match them. Reads sysfs only, neither the
// daemon nor a device, so that it needs no permissions and disturbs no device.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <nlohmann/json_fwd.hpp>

namespace slipctl {

// An array of {"driver", "id", "name", "serial", "place", "profiles", "device"}: the devices that can be
// sensors, those with a profile first. `device` is the value for the configuration. CAN and serial lines do
// not identify their devices: they list every profile of that bus.
nlohmann::ordered_json probe(const std::filesystem::path& sys = "/sys");

void print_probe(bool as_json, std::ostream& out);

}  // namespace slipctl
