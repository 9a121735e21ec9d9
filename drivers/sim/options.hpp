// The options of `sim` as its schema (options.json) has them → settings in SI units. Set-up thread.
#pragma once

#include <string>

#include "driver_api/driver.hpp"
#include "drivers/sim/simulated_sensor.hpp"

namespace slipd::sim {

struct Options {
  SensorSettings sensor;
  std::string grip_input;    // path; empty: none
  bool zeroed = true;        // see SensorInfo
  bool in_real_time = true;  // false: frames come as fast as they are taken
};

// Throws DriverError for what the schema cannot say (shear_n and load in one phase, grip_input without real
// time). A key that is absent has the schema's default.
Options parse_options(const SensorSetup& sensor);

}  // namespace slipd::sim
