// slipd-driver-usb.so: the table by which the daemon finds the driver.
#include "drivers/usb/usb_driver.hpp"
#include "embedded/usb_options.hpp"

namespace {

std::unique_ptr<slipd::DeviceDriver> create(const std::vector<slipd::SensorSetup>& sensors) {
  return std::make_unique<slipd::usb::UsbDriver>(sensors);
}

const slipd::DriverModule kModule{slipd::kDriverAbi, "usb",
                                  "sensors that are USB devices (libusb), described by a profile",
                                  slipd::usb_options.data(), create};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
