// A force sensor of HID's Sensors page: one collection of type Force, in it, behind a byte for the sensor's
// state, the data field Force in millinewtons, i32 little-endian, report 1.
// Source: HID Usage Tables 1.12.
#include "tests/devices/device_model.hpp"

namespace slipd::devices {
namespace {

const TaxelLayout& layout() {
  static const TaxelLayout it = TaxelLayout::grid(1, 1, 0.01);
  return it;
}

std::vector<Packet> scan(const ScanInput& input) {
  Packet packet{1, {3}};
  put_le(packet.bytes, saturated<std::int32_t>(force_of(input.sensors[0], layout()).z_n * 1000));
  return {packet};
}

}  // namespace

const DeviceModel& hid_force() {
  static const DeviceModel model{
      .name = "hid-force",
      .summary = "HID force sensor of the Sensors page",
      .sensor_class = SensorClass::normal,
      .layout = layout(),
      .rate_hz = 100,
      .scan = scan,
      .hid = HidModel{
          .vendor = 0x1209,  // pid.codes' identifiers for tests
          .product = 0x0002,
          .report_descriptor = {0x05, 0x20, 0x09, 0x64, 0xA1, 0x00, 0x85, 0x01,  // force sensor, report 1
                                0x0A, 0x01, 0x02, 0x15, 0x00, 0x25, 0x06,        // state
                                0x75, 0x08, 0x95, 0x01, 0x81, 0x02,              //
                                0x0A, 0x94, 0x04, 0x17, 0x00, 0x00, 0x00, 0x80,  // force: all of i32
                                0x27, 0xFF, 0xFF, 0xFF, 0x7F, 0x55, 0x0D,        // thousandths
                                0x75, 0x20, 0x95, 0x01, 0x81, 0x02, 0xC0}}};
  return model;
}

}  // namespace slipd::devices
