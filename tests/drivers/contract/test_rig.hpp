// A driver on a bench: in the same process as the device that it reads, whose every taxel feels something
// constant. One factory a driver; the suite in contract_test.cpp is the same for all.
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
  virtual void order(const std::string& /*misbehaviour*/) {}  // of the device, see misbehaviour.hpp
};

// Scans a second that simulated devices are to make, of benches made from then on.
inline double device_rate_hz = 500;

struct DriverCase {
  std::string name;
  std::function<std::unique_ptr<TestRig>()> make;
  bool misbehaves = true;       // there is a device that can be told to
  bool sees_unplugging = true;  // and whose bus says when it is gone
  bool knows_losses = true;     // a lost part of a scan shows in the sequence
};

void PrintTo(const DriverCase& driver_case, std::ostream* out);

std::vector<DriverCase> all_driver_cases();

}  // namespace slipd::test
