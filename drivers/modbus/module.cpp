// slipd-driver-modbus.so: the table by which the daemon finds the driver.
#include "drivers/modbus/modbus_driver.hpp"
#include "embedded/modbus_options.hpp"

namespace {

std::unique_ptr<slipd::DeviceDriver> create(const std::vector<slipd::SensorSetup>& sensors) {
  return std::make_unique<slipd::modbus::ModbusDriver>(sensors);
}

const slipd::DriverModule kModule{
    slipd::kDriverAbi, "modbus", "force sensors polled over Modbus (TCP or RTU), each described by a profile",
    slipd::modbus_options.data(), create};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
