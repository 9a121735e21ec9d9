// iCub's MTB skin board: triangles of 12 pressure taxels, two CAN frames a triangle. Id 0x400 | board << 4 |
// triangle; byte 0 is 0x00 before taxels 0–6, 0x80 before taxels 7–11 and two bytes of error flags. `07 00`
// to 0x200 | board starts it. Source: icub-main. Board 1 with four triangles, taken as rows of a grid; a
// count is 500 Pa, and falls when pressed.
#include "tests/devices/device_model.hpp"

namespace slipd::devices {
namespace {

constexpr std::uint32_t kFirstTriangle = 0x410, kCommand = 0x201;
constexpr std::size_t kTriangles = 4, kTaxels = 12, kInFirst = 7;
constexpr double kZero = 245, kPa = 500;

std::vector<Packet> scan(const ScanInput& input) {
  std::vector<Packet> packets;
  for (std::uint32_t triangle = 0; triangle < kTriangles; ++triangle) {
    Packet first{kFirstTriangle + triangle, {0x00}}, second{kFirstTriangle + triangle, {0x80}};
    for (std::size_t taxel = 0; taxel < kTaxels; ++taxel) {
      const double pressure = input.sensors[0].normal_pa[triangle * kTaxels + taxel];
      (taxel < kInFirst ? first : second).bytes.push_back(saturated<std::uint8_t>(kZero - pressure / kPa));
    }
    append(second.bytes, {0, 0});
    packets.push_back(first);
    packets.push_back(second);
  }
  return packets;
}

void receive(const Packet& said, HostState& host) {
  if (said.address == kCommand && said.bytes.size() >= 2 && said.bytes[0] == 0x07)
    host.streaming = said.bytes[1] == 0;
}

}  // namespace

const DeviceModel& icub_skin() {
  static const DeviceModel model{.name = "icub-skin",
                                 .summary = "iCub MTB skin board, 4 triangles of 12 taxels on CAN",
                                 .sensor_class = SensorClass::normal,
                                 .layout = TaxelLayout::grid(kTaxels, kTriangles, 0.005),
                                 .rate_hz = 50,
                                 .starts_by_itself = false,
                                 .scan = scan,
                                 .receive = receive};
  return model;
}

}  // namespace slipd::devices
