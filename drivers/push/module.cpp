// slipd-driver-push.so: the table by which the daemon finds the driver.
#include "drivers/push/push_driver.hpp"
#include "embedded/push_options.hpp"

namespace {

std::unique_ptr<slipd::DeviceDriver> create(const std::vector<slipd::SensorSetup>& sensors) {
  return std::make_unique<slipd::push::PushDriver>(sensors);
}

const slipd::DriverModule kModule{slipd::kDriverAbi, "push",
                                  "frames that a program sends to a local socket, from any language",
                                  slipd::push_options.data(), create};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
