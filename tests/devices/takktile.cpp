// TakkTile's USB array: barometers under rubber, vendor class. Bulk IN 0x81 carries 4 bytes a cell, pressure
// and temperature, each 10 bits left-aligned in a big-endian u16. Control IN 0x5C: a byte a cell, 255 =
// alive; 0x6C: 8 bytes of calibration of cell wIndex; 0xC7: start with wValue = period, stop with 0. Source:
// the public takktile_usb. The cells are MPL115A2 with that data model's example calibration at 25 °C: a
// count less is 127.3 Pa more.
#include "tests/devices/device_model.hpp"

namespace slipd::devices {
namespace {

constexpr std::size_t kColumns = 5, kRows = 8;
constexpr double kZero = 394, kPaPerCount = -127.3;
constexpr std::uint16_t kTemperature = 472;

std::vector<Packet> scan(const ScanInput& input) {
  Packet packet{0x81, {}};
  for (const float pressure : input.sensors[0].normal_pa) {
    const double counts = std::clamp(std::round(kZero + pressure / kPaPerCount), 0.0, 1023.0);
    put_be(packet.bytes, static_cast<std::uint16_t>(static_cast<unsigned>(counts) << 6));
    put_be(packet.bytes, static_cast<std::uint16_t>(kTemperature << 6));
  }
  return {packet};
}

std::optional<Bytes> request(const UsbRequest& asked, HostState& host) {
  switch (asked.request) {
    case 0x5C:
      return Bytes(kColumns * kRows, 255);
    case 0x6C:
      return Bytes{0x3E, 0xCE, 0xB3, 0xF9, 0xC5, 0x17, 0x33, 0xC8};
    case 0xC7:
      host.streaming = asked.value != 0;
      return Bytes{1};
    default:
      return std::nullopt;
  }
}

}  // namespace

const DeviceModel& takktile() {
  static const DeviceModel model{
      .name = "takktile",
      .summary = "TakkTile, 5 x 8 pressure cells on USB",
      .sensor_class = SensorClass::normal,
      .layout = TaxelLayout::grid(kColumns, kRows, 0.008),
      .rate_hz = 60,
      .starts_by_itself = false,
      .scan = scan,
      .usb = UsbModel{.vendor = 0x59e3,
                      .product = 0x74c7,
                      .device_class = 0xFF,
                      .in_endpoint = 0x81,
                      .configuration = {9, 2, 0,    0, 1,  1,    0, 0x80, 100,  //
                                        9, 4, 0,    0, 1,  0xFF, 0, 0,    0,    // vendor interface
                                        7, 5, 0x81, 2, 64, 0,    0},            // bulk IN
                      .request = request}};
  return model;
}

}  // namespace slipd::devices
