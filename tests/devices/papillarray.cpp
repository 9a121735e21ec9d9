// Contactile's PapillArray hub: two sensors of 3 x 3 pillars on CDC-ACM, PTS 2.0. A packet is 55 66 77 88,
// data, AA BB CC DD. Data: width of offsets W = 2, a table of {type u16, offset u16} that ends at the
// smallest offset, zeros between, blocks, sum16 of what is before it. All little-endian; every offset counts
// from W. Blocks of sensors hold the number of sensors and an offset for each; of pillars, at that offset,
// the number of pillars and an offset for each.
//   T1 u32 counter, u64 µs · T3 a pillar: u16 2, force N, displacement mm · T4 a sensor: u16 2, force N,
//   torque Nmm T5 a pillar: u16 1, i8 slip, f32 mu · T6 a sensor: u16 1, u8 state, f32 mu, f32 grip · T7
//   unknown, one byte here
// Source: a third party's description of a recorded stream. Streams by itself; `z\n` takes the bias.
#include <array>

#include "tests/devices/cdc_acm.hpp"

namespace slipd::devices {
namespace {

constexpr std::size_t kPillars = 9, kOffset = 2;
constexpr float kMmPerNewton = 0.5F, kUnknownFriction = -1;

const TaxelLayout& layout() {
  static const TaxelLayout it = TaxelLayout::grid(3, 3, 0.007);
  return it;
}

// A list: how many, where each begins (counted from W, the list itself beginning at `at`), then the items.
template <class Item>
Bytes list(std::size_t at, std::size_t count, Item&& item) {
  Bytes head, body;
  put_le(head, static_cast<std::uint16_t>(count));
  const std::size_t head_size = kOffset * (1 + count);
  for (std::size_t i = 0; i < count; ++i) {
    put_le(head, static_cast<std::uint16_t>(at + head_size + body.size()));
    append(body, item(i, at + head_size + body.size()));
  }
  append(head, body);
  return head;
}

Bytes floats(std::uint16_t kind, std::array<float, 6> values) {
  Bytes out;
  put_le(out, kind);
  for (const float value : values) put_le(out, value);
  return out;
}

Bytes pillar(const Frame& frame, std::size_t i) {
  const Force force = force_of(frame, layout(), i);
  const auto x = static_cast<float>(force.x_n), y = static_cast<float>(force.y_n),
             z = static_cast<float>(force.z_n);
  return floats(2, {x, y, z, x * kMmPerNewton, y * kMmPerNewton, z * kMmPerNewton});
}

Bytes whole(const Frame& frame) {
  Force sum;
  for (std::size_t i = 0; i < kPillars; ++i) {
    const Force force = force_of(frame, layout(), i);
    sum = {sum.x_n + force.x_n, sum.y_n + force.y_n, sum.z_n + force.z_n};
  }
  return floats(
      2, {static_cast<float>(sum.x_n), static_cast<float>(sum.y_n), static_cast<float>(sum.z_n), 0, 0, 0});
}

Bytes no_slip(std::initializer_list<float> values) {
  Bytes out;
  put_le(out, std::uint16_t{1});
  out.push_back(0);
  for (const float value : values) put_le(out, value);
  return out;
}

std::vector<Packet> scan(const ScanInput& input) {
  constexpr std::array<std::uint16_t, 6> types{1, 3, 4, 5, 6, 7};
  constexpr std::size_t padding = 2, first = 1 + types.size() * 4 + padding;
  const std::size_t sensors = input.sensors.size();

  Bytes table, blocks;
  for (const std::uint16_t type : types) {
    const std::size_t at = first + blocks.size();
    put_le(table, type);
    put_le(table, static_cast<std::uint16_t>(at));
    const auto per_pillar = [&](auto&& item) {
      return list(at, sensors, [&](std::size_t sensor, std::size_t here) {
        return list(here, kPillars,
                    [&](std::size_t i, std::size_t) { return item(input.sensors[sensor], i); });
      });
    };
    switch (type) {
      case 1:
        put_le(blocks, static_cast<std::uint32_t>(input.scan));
        put_le(blocks, input.time_us);
        break;
      case 3:
        append(blocks, per_pillar(pillar));
        break;
      case 4:
        append(blocks, list(at, sensors, [&](auto i, auto) { return whole(input.sensors[i]); }));
        break;
      case 5:
        append(blocks, per_pillar([](auto&, auto) { return no_slip({kUnknownFriction}); }));
        break;
      case 6:
        append(blocks, list(at, sensors, [](auto, auto) { return no_slip({kUnknownFriction, 0}); }));
        break;
      default:
        blocks.push_back(0);
    }
  }

  Bytes data{kOffset};
  append(data, table);
  data.resize(first, 0);
  append(data, blocks);
  std::uint16_t sum = 0;
  for (const std::uint8_t byte : data) sum = static_cast<std::uint16_t>(sum + byte);

  Packet packet{0x81, {0x55, 0x66, 0x77, 0x88}};
  append(packet.bytes, data);
  put_le(packet.bytes, sum);
  append(packet.bytes, {0xAA, 0xBB, 0xCC, 0xDD});
  return {packet};
}

}  // namespace

const DeviceModel& papillarray() {
  static const DeviceModel model{.name = "papillarray",
                                 .summary = "Contactile PapillArray hub, two sensors of 3 x 3 pillars on USB",
                                 .sensor_class = SensorClass::array3,
                                 .layout = layout(),
                                 .sensors = 2,
                                 .rate_hz = 100,
                                 .scan = scan,
                                 .usb = cdc_acm(0x16c0, 0x0483)};
  return model;
}

}  // namespace slipd::devices
