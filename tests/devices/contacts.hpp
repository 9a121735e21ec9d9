// The contacts of simulated devices.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "tests/devices/device_simulator.hpp"

namespace slipd::devices {

// Contacts by the model and script of driver sim, so that the truth is known. `options` are those of that
// driver; each sensor of the device has a seed of its own. A scan advances time by 1 / rate_hz and reads no
// clock. Throws DriverError, std::invalid_argument or contact::ContactError for invalid options.
std::vector<Contact> scripted(const DeviceModel& model, double rate_hz, const nlohmann::json& options);

// A pattern in which every taxel, axis and sensor differs, so that an exchanged one is found: taxel i of
// sensor s has a normal pressure of 1000 (i + 1) + 100 s Pa, shear x of half of it and shear y of minus a
// quarter. There is no truth, since no contact of two bodies has this shape.
std::vector<Contact> pattern(const DeviceModel& model);

// Weights that people lay on a pad or hang from it, as `file` says before each scan: five numbers, the forces
// along x, y and the normal (N) and the place of their middle (mm). No file: nothing lies there. The taxels
// within a taxel's pitch of the place carry them alike, with noise of a fiftieth of a newton in all. There
// is no truth.
std::vector<Contact> weights(const DeviceModel& model, const std::filesystem::path& file);

}  // namespace slipd::devices
