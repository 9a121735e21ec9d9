// slipd-driver-replay.so: the table by which the daemon finds the driver.
#include "driver_api/driver.hpp"
#include "drivers/replay/replay_driver.hpp"
#include "embedded/replay_options.hpp"

namespace {

std::unique_ptr<slipd::DeviceDriver> create(const std::vector<slipd::SensorSetup>& sensors) {
  return std::make_unique<slipd::replay::ReplayDriver>(sensors);
}

const slipd::DriverModule kModule{slipd::kDriverAbi, "replay", "plays recordings of slipd and CSV files",
                                  slipd::replay_options.data(), create};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
