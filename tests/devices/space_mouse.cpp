// A 3Dconnexion six-axis device, as a source of forces on the bench: HID, report 1 is the translation,
// report 2 the rotation, each 3 x i16 little-endian within ±350. Source: public drivers. A count is 0.01 N
// here. The real device sends nothing at rest; this one does.
#include "tests/devices/device_model.hpp"

namespace slipd::devices {
namespace {

constexpr double kCountsPerNewton = 100, kMost = 350;

const TaxelLayout& layout() {
  static const TaxelLayout it = TaxelLayout::wrench(0.01);
  return it;
}

std::vector<Packet> scan(const ScanInput& input) {
  const Force force = force_of(input.sensors[0], layout());
  Packet pushed{1, {}};
  for (const double newton : {force.x_n, force.y_n, force.z_n})
    put_le(pushed.bytes, saturated<std::int16_t>(std::clamp(newton * kCountsPerNewton, -kMost, kMost)));
  return {pushed, {2, Bytes(6, 0)}};
}

}  // namespace

const DeviceModel& space_mouse() {
  static const DeviceModel model{
      .name = "space-mouse",
      .summary = "3Dconnexion six-axis device on HID",
      .sensor_class = SensorClass::wrench,
      .layout = layout(),
      .rate_hz = 60,
      .scan = scan,
      .hid = HidModel{
          .vendor = 0x256f,
          .product = 0xc635,
          .report_descriptor = {0x05, 0x01, 0x09, 0x08, 0xA1, 0x01,              // multi-axis controller
                                0x16, 0xA2, 0xFE, 0x26, 0x5E, 0x01, 0x75, 0x10,  // ±350, 16 bits
                                0x85, 0x01, 0x09, 0x30, 0x09, 0x31, 0x09, 0x32,  // report 1: x, y, z
                                0x95, 0x03, 0x81, 0x06,                          //
                                0x85, 0x02, 0x09, 0x33, 0x09, 0x34, 0x09, 0x35,  // report 2: rotations
                                0x95, 0x03, 0x81, 0x06, 0xC0}}};
  return model;
}

}  // namespace slipd::devices
