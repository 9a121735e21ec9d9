// A HID sensor with a raw vendor page: reports of 64 bytes without an id, one scan split over several. No
// published tactile sensor has such a layout to follow. This one has 8 x 8 taxels of three axes, ten to a
// report: scan number u8, part u8, parts u8, taxels in this part u8, then for each taxel normal u16, shear x
// and y i16, little-endian, 5 Pa a count.
#include "tests/devices/device_model.hpp"

namespace slipd::devices {
namespace {

constexpr std::size_t kTaxels = 64, kInReport = 10, kParts = (kTaxels + kInReport - 1) / kInReport,
                      kReport = 64;
constexpr double kPa = 5;

std::vector<Packet> scan(const ScanInput& input) {
  const Frame& frame = input.sensors[0];
  std::vector<Packet> packets;
  for (std::size_t part = 0; part < kParts; ++part) {
    const std::size_t first = part * kInReport, last = std::min(first + kInReport, kTaxels);
    Packet packet{0,
                  {static_cast<std::uint8_t>(input.scan), static_cast<std::uint8_t>(part),
                   static_cast<std::uint8_t>(kParts), static_cast<std::uint8_t>(last - first)}};
    for (std::size_t i = first; i < last; ++i) {
      put_le(packet.bytes, saturated<std::uint16_t>(frame.normal_pa[i] / kPa));
      put_le(packet.bytes, saturated<std::int16_t>(frame.shear_x_pa[i] / kPa));
      put_le(packet.bytes, saturated<std::int16_t>(frame.shear_y_pa[i] / kPa));
    }
    packet.bytes.resize(kReport, 0);
    packets.push_back(packet);
  }
  return packets;
}

}  // namespace

const DeviceModel& vendor_hid() {
  static const DeviceModel model{
      .name = "vendor-hid",
      .summary = "Vendor HID, 8 x 8 taxels of three axes in 7 reports",
      .sensor_class = SensorClass::array3,
      .layout = TaxelLayout::grid(8, 8, 0.002),
      .rate_hz = 100,
      .scan = scan,
      .hid = HidModel{.vendor = 0x1209,  // pid.codes' identifiers for tests
                      .product = 0x0001,
                      .report_descriptor = {0x06, 0x00, 0xFF,        // usage page: vendor
                                            0x09, 0x01, 0xA1, 0x01,  // usage 1, collection: application
                                            0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08,  // bytes
                                            0x95, 0x40, 0x09, 0x02, 0x81, 0x02,        // 64 in
                                            0x95, 0x40, 0x09, 0x03, 0x91, 0x02,        // 64 out
                                            0xC0}}};
  return model;
}

}  // namespace slipd::devices
