// slipd-driver-can.so: the table by which the daemon finds the driver.
#include "drivers/can/can_driver.hpp"
#include "embedded/can_options.hpp"

namespace {

std::unique_ptr<slipd::DeviceDriver> create(const std::vector<slipd::SensorSetup>& sensors) {
  return std::make_unique<slipd::can::CanDriver>(sensors);
}

const slipd::DriverModule kModule{slipd::kDriverAbi, "can",
                                  "sensors on a CAN bus (SocketCAN), each described by a profile",
                                  slipd::can_options.data(), create};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
