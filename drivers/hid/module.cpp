// slipd-driver-hid.so: the table by which the daemon finds the driver.
#include "drivers/hid/hid_driver.hpp"
#include "embedded/hid_options.hpp"

namespace {

std::unique_ptr<slipd::DeviceDriver> create(const std::vector<slipd::SensorSetup>& sensors) {
  return std::make_unique<slipd::hid::HidDriver>(sensors);
}

const slipd::DriverModule kModule{slipd::kDriverAbi, "hid",
                                  "sensors that are HID devices (hidraw), each described by a profile",
                                  slipd::hid_options.data(), create};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
