// slipctl probe: what is plugged in, and which profile would match. Asks the kernel (sysfs), no daemon and no
// device, so that it needs no rights and disturbs nobody.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <nlohmann/json_fwd.hpp>

namespace slipctl {

// An array of {"driver", "id", "name", "serial", "place", "profiles", "device"}: what may carry a sensor,
// those with a profile first. `device` is what to write into the configuration. On CAN and on serial lines
// nothing says what is there: every profile of that bus is named.
nlohmann::ordered_json probe(const std::filesystem::path& sys = "/sys");

void print_probe(bool as_json, std::ostream& out);

}  // namespace slipctl
