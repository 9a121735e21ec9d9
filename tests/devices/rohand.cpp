// OYMotion ROHand: a hand that measures the normal force of each of its five fingers. Modbus RTU, 115200
// 8N1, unit 2: registers 1120–1124, u16, mN. Source: the maker's register map.
#include "tests/devices/device_model.hpp"

namespace slipd::devices {
namespace {

constexpr int kFirst = 1120;
constexpr std::size_t kFingers = 5;

const TaxelLayout& layout() {
  static const TaxelLayout it = TaxelLayout::grid(1, 1, 0.015);
  return it;
}

std::vector<Packet> scan(const ScanInput& input) {
  Packet packet{kFirst, {}};
  for (const Frame& finger : input.sensors)
    put_be(packet.bytes, saturated<std::uint16_t>(force_of(finger, layout()).z_n * 1000));
  return {packet};
}

}  // namespace

const DeviceModel& rohand() {
  static const DeviceModel model{
      .name = "rohand",
      .summary = "OYMotion ROHand, five fingers, Modbus RTU",
      .sensor_class = SensorClass::normal,
      .layout = layout(),
      .sensors = kFingers,
      .rate_hz = 50,
      .scan = scan,
      .modbus = ModbusModel{.unit = 2, .baud = 115200, .first_register = kFirst, .registers = kFingers}};
  return model;
}

}  // namespace slipd::devices
