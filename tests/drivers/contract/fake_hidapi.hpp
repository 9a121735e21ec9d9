// A stand-in for hidapi with one device, that of the last call. A program that links it has these functions
// before those of the library.
#pragma once

#include <memory>

#include "tests/devices/memory_port.hpp"

namespace slipd::test {

void plug_into_fake_hidapi(const devices::DeviceModel& model, std::shared_ptr<devices::MemoryBus> bus);

}  // namespace slipd::test
