#include "drivers/usb/usb_driver.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace slipd::usb {
namespace {

DeviceSelector selector_of(const SensorSetup& sensor) {
  try {
    return {sensor.device.value("serial", ""), sensor.device.value("port", "")};
  } catch (const nlohmann::json::exception&) {
    throw DriverError("sensor \"" + sensor.name +
                      "\": device: expected {\"serial\": \"…\"} or {\"port\": \"1-2.3\"}, or nothing");
  }
}

}  // namespace

UsbDriver::UsbDriver(const std::vector<SensorSetup>& sensors, Opener opener)
    : StreamDriver(decode::profile_of(sensors, "usb"), sensors),
      selector_(selector_of(sensors.front())),
      opener_(std::move(opener)) {}

}  // namespace slipd::usb
