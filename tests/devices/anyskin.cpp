// AnySkin: five magnetometers, each with temperature, x, y, z as little-endian f32, then CR LF. Source: the
// makers' firmware and reader. The chips are turned against each other as the makers' viewer draws them: the
// board's x and y are here what the profile has to find in the chips' own. The board is a serial port on USB.
#include "tests/devices/cdc_acm.hpp"
#include "tests/devices/device_model.hpp"

namespace slipd::devices {
namespace {

constexpr float kDegreesC = 25;

const TaxelLayout& layout() {
  static const TaxelLayout it = TaxelLayout::scattered({0, -0.006, 0.006, 0, 0}, {0, 0, 0, 0.006, -0.006});
  return it;
}

std::vector<Packet> scan(const ScanInput& input) {
  const Frame& frame = input.sensors[0];
  Packet packet{0, {}};
  for (std::size_t chip = 0; chip < 5; ++chip) {
    const float x = frame.shear_x_pa[chip], y = frame.shear_y_pa[chip];
    const float own[5][2] = {{y, x}, {y, x}, {-x, y}, {-y, -x}, {x, -y}};
    for (const float value : {kDegreesC, own[chip][0], own[chip][1], frame.normal_pa[chip]})
      put_le(packet.bytes, value);
  }
  append(packet.bytes, {'\r', '\n'});
  return {packet};
}

}  // namespace

const DeviceModel& anyskin() {
  static const DeviceModel model{.name = "anyskin",
                                 .summary = "AnySkin, five magnetometers on a serial line",
                                 .sensor_class = SensorClass::array3,
                                 .layout = layout(),
                                 .rate_hz = 100,
                                 .scan = scan,
                                 .usb = cdc_acm(0x239a, 0x80cb)};
  return model;
}

}  // namespace slipd::devices
