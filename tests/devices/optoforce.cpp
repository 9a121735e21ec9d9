// OptoForce's DAQ with one three-axis sensor: CDC-ACM, streams by itself. A frame has 16 bytes: AA 07 08 0A,
// u16 counter, u16 status, force x, y, z as i16, sum16 of what is before it; all big-endian. Source: public
// drivers, which state header, order and sum; a count is 0.01 N here, as each sensor has a scale of its own.
#include "tests/devices/cdc_acm.hpp"

namespace slipd::devices {
namespace {

constexpr double kCountsPerNewton = 100;

const TaxelLayout& layout() {
  static const TaxelLayout it = TaxelLayout::wrench(0.01);
  return it;
}

std::vector<Packet> scan(const ScanInput& input) {
  const Force force = force_of(input.sensors[0], layout());
  Packet packet{0x81, {0xAA, 0x07, 0x08, 0x0A}};
  put_be(packet.bytes, static_cast<std::uint16_t>(input.scan));
  put_be(packet.bytes, std::uint16_t{0});
  for (const double newton : {force.x_n, force.y_n, force.z_n})
    put_be(packet.bytes, saturated<std::int16_t>(newton * kCountsPerNewton));
  std::uint16_t sum = 0;
  for (const std::uint8_t byte : packet.bytes) sum = static_cast<std::uint16_t>(sum + byte);
  put_be(packet.bytes, sum);
  return {packet};
}

}  // namespace

const DeviceModel& optoforce() {
  static const DeviceModel model{.name = "optoforce",
                                 .summary = "OptoForce DAQ with one three-axis sensor on USB",
                                 .sensor_class = SensorClass::wrench,
                                 .layout = layout(),
                                 .rate_hz = 100,
                                 .scan = scan,
                                 .usb = cdc_acm(0x04d8, 0x000a)};
  return model;
}

}  // namespace slipd::devices
