// slipd-driver-sim.so: the table by which the daemon finds the driver.
#include "driver_api/driver.hpp"
#include "drivers/sim/sim_driver.hpp"
#include "embedded/sim_options.hpp"

namespace {

std::unique_ptr<slipd::DeviceDriver> create(const std::vector<slipd::SensorSetup>& sensors) {
  return std::make_unique<slipd::sim::SimDriver>(sensors);
}

const slipd::DriverModule kModule{slipd::kDriverAbi, "sim",
                                  "a sensor that is computed, with its contact's history and its truth",
                                  slipd::sim_options.data(), create};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
