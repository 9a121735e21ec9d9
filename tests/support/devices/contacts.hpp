// The contacts of simulated devices.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "tests/support/devices/device_simulator.hpp"

namespace slipd::devices {

// The contact model and script of driver sim, so that the truth is known. `options` are those of that driver;
// each sensor of the device has a seed of its own. A scan moves time on by 1 / rate_hz, whatever the clock
// says. Throws DriverError, std::invalid_argument or contact::ContactError for options without meaning.
std::vector<Contact> scripted(const DeviceModel& model, double rate_hz, const nlohmann::json& options);

// A pattern in which every taxel, axis and sensor differs, so that a swapped one shows: taxel i of sensor s
// has a normal pressure of 1000 (i + 1) + 100 s Pa, shear x of half that and shear y of minus a quarter. No
// truth: no contact of two bodies looks like it.
std::vector<Contact> pattern(const DeviceModel& model);

}  // namespace slipd::devices
