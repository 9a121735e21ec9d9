// Robotiq FT 300: a wrist force sensor. Modbus RTU, unit 9, 19200 8N1: force in registers 180–182 (i16, N x
// 100), torque in 183–185 (Nm x 1000).
#include "tests/devices/device_model.hpp"

namespace slipd::devices {
namespace {

constexpr int kFirst = 180, kRegisters = 6;

const TaxelLayout& layout() {
  static const TaxelLayout it = TaxelLayout::wrench(0.02);
  return it;
}

std::vector<Packet> scan(const ScanInput& input) {
  const Force force = force_of(input.sensors[0], layout());
  Packet packet{kFirst, {}};
  for (const double newton : {force.x_n, force.y_n, force.z_n}) {
    put_be(packet.bytes, saturated<std::int16_t>(newton * 100));
  }
  packet.bytes.resize(2 * kRegisters, 0);  // the contact is in the middle: no torque
  return {packet};
}

}  // namespace

const DeviceModel& robotiq_ft300() {
  static const DeviceModel model{
      .name = "robotiq-ft300",
      .summary = "Robotiq FT 300, one force sensor, Modbus RTU",
      .sensor_class = SensorClass::wrench,
      .layout = layout(),
      .rate_hz = 100,
      .scan = scan,
      .modbus = ModbusModel{.unit = 9, .baud = 19200, .first_register = kFirst, .registers = kRegisters}};
  return model;
}

}  // namespace slipd::devices
