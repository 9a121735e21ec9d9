// Robotiq TSF-85: two fingers of 4 x 7 pressure cells and a vibration channel on CDC-ACM. Packet: 9A, crc8
// (over what follows), command, length, data of fields, each behind a tag type << 4 | finger << 2. Type 1: 28
// x u16; 2: i16; 7: u64 time; all big-endian. `58` + period in ms starts it, period 0 stops it; a packet
// holds at most 60 bytes of data, so each finger has one. Source: Robotiq's BSD SDK, which fills no crc in;
// here it is CRC-8 with polynomial 07. A count is 20 Pa.
#include "tests/devices/cdc_acm.hpp"

namespace slipd::devices {
namespace {

constexpr std::uint8_t kStart = 0x9A, kAutosend = 0x58;
constexpr std::uint8_t kPressures = 1 << 4, kDynamic = 2 << 4, kTime = 7 << 4;
constexpr double kPa = 20;

std::uint8_t crc8(const Bytes& bytes) {
  unsigned crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1) ^ ((crc & 0x80U) ? 0x107U : 0U);
  }
  return static_cast<std::uint8_t>(crc);
}

Packet packet_of(const Bytes& data) {
  Bytes checked{kAutosend, static_cast<std::uint8_t>(data.size())};
  append(checked, data);
  Packet packet{0x81, {kStart, crc8(checked)}};
  append(packet.bytes, checked);
  return packet;
}

std::vector<Packet> scan(const ScanInput& input) {
  std::vector<Packet> packets;
  Bytes rest;
  for (std::size_t finger = 0; finger < input.sensors.size(); ++finger) {
    const auto tag = static_cast<std::uint8_t>(finger << 2);
    Bytes data{static_cast<std::uint8_t>(kPressures | tag)};
    for (const float pressure : input.sensors[finger].normal_pa)
      put_be(data, saturated<std::uint16_t>(pressure / kPa));
    packets.push_back(packet_of(data));
    rest.push_back(static_cast<std::uint8_t>(kDynamic | tag));
    put_be(rest, std::int16_t{0});
  }
  rest.push_back(kTime);
  put_be(rest, input.time_us);
  packets.push_back(packet_of(rest));
  return packets;
}

void receive(const Packet& said, HostState& host) {  // 9A crc 58 01 period
  if (said.bytes.size() == 5 && said.bytes[0] == kStart && said.bytes[2] == kAutosend)
    host.streaming = said.bytes[4] != 0;
}

}  // namespace

const DeviceModel& robotiq_tsf85() {
  static const DeviceModel model{.name = "robotiq-tsf85",
                                 .summary = "Robotiq TSF-85, two fingers of 4 x 7 cells on USB",
                                 .sensor_class = SensorClass::normal,
                                 .layout = TaxelLayout::grid(4, 7, 0.0055),
                                 .sensors = 2,
                                 .rate_hz = 60,
                                 .starts_by_itself = false,
                                 .scan = scan,
                                 .receive = receive,
                                 .usb = cdc_acm(0x16d0, 0x14cc)};
  return model;
}

}  // namespace slipd::devices
