// slipd-driver-serial.so: the table by which the daemon finds the driver.
#include "drivers/serial/serial_driver.hpp"
#include "embedded/serial_options.hpp"

namespace {

std::unique_ptr<slipd::DeviceDriver> create(const std::vector<slipd::SensorSetup>& sensors) {
  return std::make_unique<slipd::serial::SerialDriver>(sensors);
}

const slipd::DriverModule kModule{
    slipd::kDriverAbi, "serial",
    "sensors on a serial line (UART, USB adapter, CDC-ACM), described by a profile",
    slipd::serial_options.data(), create};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
