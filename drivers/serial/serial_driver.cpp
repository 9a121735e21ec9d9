#include "drivers/serial/serial_driver.hpp"

#include <nlohmann/json.hpp>

#include "drivers/serial/serial_transport.hpp"

namespace slipd::serial {
namespace {

constexpr std::uint32_t kLeastBaud = 50, kMostBaud = 12'000'000;

[[noreturn]] void wrong_device(const SensorSetup& sensor) {
  throw DriverError("sensor \"" + sensor.name +
                    "\": device: expected {\"path\": \"/dev/serial/by-id/…\"}; baud may be given beside");
}

}  // namespace

SerialDriver::SerialDriver(const std::vector<SensorSetup>& sensors)
    : StreamDriver(decode::profile_of(sensors, "serial"), sensors), line_(*profile().serial) {
  const SensorSetup& sensor = sensors.front();
  try {
    path_ = sensor.device.value("path", "");
    line_.baud = sensor.device.value("baud", line_.baud);
  } catch (const nlohmann::json::exception&) {
    wrong_device(sensor);
  }
  if (path_.empty() || line_.baud < kLeastBaud || line_.baud > kMostBaud) wrong_device(sensor);
}

decode::OpenedDevice SerialDriver::open_device() {
  return {std::make_unique<SerialTransport>(path_, profile(), line_), path_, ""};
}

}  // namespace slipd::serial
