// slipd-driver-foreign.so: a module of a driver interface that this slipd does not have. Not installed.
#include "driver_api/driver.hpp"

namespace {

const slipd::DriverModule kModule{slipd::kDriverAbi + 1, "foreign", "of another interface, for tests", "{}",
                                  nullptr};

}  // namespace

SLIPD_DRIVER_MODULE(kModule)
