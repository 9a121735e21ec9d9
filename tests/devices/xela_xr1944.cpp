// XELA uSkin XR1944: 4 x 4 taxels of three axes, one CAN frame a taxel. Id 0x700 | board << 4 | taxel; byte
// 0 unused, then X, Y, Z as big-endian u16. Board 1. `07 00` to 0x200 | board starts it. Source: the public
// ur-o2as driver. The real sensor's counts are uncalibrated; here a count is 40 Pa for pressure and 20 Pa
// for shear, with an offset of 30000.
#include "tests/devices/device_model.hpp"

namespace slipd::devices {
namespace {

constexpr std::uint32_t kFirstTaxel = 0x710, kCommand = 0x201;
constexpr double kZero = 30000, kNormalPa = 40, kShearPa = 20;

std::vector<Packet> scan(const ScanInput& input) {
  const Frame& frame = input.sensors[0];
  std::vector<Packet> packets;
  for (std::uint32_t taxel = 0; taxel < frame.normal_pa.size(); ++taxel) {
    Packet& packet = packets.emplace_back(Packet{kFirstTaxel + taxel, {0}});
    put_be(packet.bytes, saturated<std::uint16_t>(kZero + frame.shear_x_pa[taxel] / kShearPa));
    put_be(packet.bytes, saturated<std::uint16_t>(kZero + frame.shear_y_pa[taxel] / kShearPa));
    put_be(packet.bytes, saturated<std::uint16_t>(kZero + frame.normal_pa[taxel] / kNormalPa));
  }
  return packets;
}

void receive(const Packet& said, HostState& host) {
  if (said.address == kCommand && said.bytes == Bytes{0x07, 0x00}) host.streaming = true;
}

}  // namespace

const DeviceModel& xela_xr1944() {
  static const DeviceModel model{.name = "xela-xr1944",
                                 .summary = "XELA uSkin XR1944, 4 x 4 taxels of three axes on CAN",
                                 .sensor_class = SensorClass::array3,
                                 .layout = TaxelLayout::grid(4, 4, 0.0047),
                                 .rate_hz = 100,
                                 .starts_by_itself = false,
                                 .scan = scan,
                                 .receive = receive};
  return model;
}

}  // namespace slipd::devices
