// OnRobot RG2-FT: a gripper with a force sensor in each finger. Modbus TCP, unit 65, 26 registers from 257:
// left force at 2–4 (i16, 0.1 N), left torque at 5–7 (0.01 Nm), right at 11–13 and 14–16; width 23 (0.1 mm),
// busy 24, grip 25.
#include "tests/devices/device_model.hpp"

namespace slipd::devices {
namespace {

constexpr int kFirst = 257, kRegisters = 26;
constexpr std::size_t kWidth = 23, kGrip = 25;
constexpr std::int16_t kWidthTenthMm = 300;

const TaxelLayout& layout() {
  static const TaxelLayout it = TaxelLayout::wrench(0.018);
  return it;
}

std::vector<Packet> scan(const ScanInput& input) {
  std::vector<std::int16_t> registers(kRegisters, 0);
  bool gripping = false;
  for (const std::size_t finger : {0U, 1U}) {
    const Force force = force_of(input.sensors[finger], layout());
    const std::size_t at = finger == 0 ? 2 : 11;
    registers[at] = saturated<std::int16_t>(force.x_n * 10);
    registers[at + 1] = saturated<std::int16_t>(force.y_n * 10);
    registers[at + 2] = saturated<std::int16_t>(force.z_n * 10);
    gripping = gripping || force.z_n > 0;
  }
  registers[kWidth] = kWidthTenthMm;
  registers[kGrip] = gripping ? 1 : 0;
  Packet packet{kFirst, {}};
  for (const std::int16_t value : registers) put_be(packet.bytes, value);
  return {packet};
}

}  // namespace

const DeviceModel& onrobot_rg2ft() {
  static const DeviceModel model{
      .name = "onrobot-rg2-ft",
      .summary = "OnRobot RG2-FT, a force sensor in each finger, Modbus TCP",
      .sensor_class = SensorClass::wrench,
      .layout = layout(),
      .sensors = 2,
      .rate_hz = 100,
      .scan = scan,
      .modbus = ModbusModel{.unit = 65, .first_register = kFirst, .registers = kRegisters}};
  return model;
}

}  // namespace slipd::devices
