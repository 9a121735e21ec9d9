// A driver in the same process as the simulated device that it reads, with constant values on every taxel.
// One factory per driver; the suite in contract_test.cpp is the same for all.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "driver_api/driver.hpp"

namespace slipd::test {

class TestRig {
 public:
  virtual ~TestRig() = default;
  virtual DeviceDriver& driver() = 0;
  virtual void order(const std::string& /*misbehaviour*/) {}  // to the device, see misbehaviour.hpp
};

// Scans per second of the simulated devices of rigs that are created afterwards.
inline double device_rate_hz = 500;

struct DriverCase {
  std::string name;
  std::function<std::unique_ptr<TestRig>()> make;
  bool misbehaves = true;       // the rig has a device that takes orders
  bool sees_unplugging = true;  // the bus reports when the device is unplugged
  bool knows_losses = true;     // the sequence shows a lost part of a scan
};

void PrintTo(const DriverCase& driver_case, std::ostream* out);

std::vector<DriverCase> all_driver_cases();

}  // namespace slipd::test
