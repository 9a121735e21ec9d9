// JSON → Profile.
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "drivers/decode/profile_parts.hpp"

namespace slipd::decode {
namespace {

using nlohmann::json;

constexpr double kMetresPerMm = 1e-3;

std::uint32_t id_of(const json& in) {
  return in.is_string() ? static_cast<std::uint32_t>(std::stoul(in.get<std::string>(), nullptr, 16))
                        : in.get<std::uint32_t>();
}

std::optional<unsigned> shift_of(const json& in) {
  if (!in.contains("board_shift")) return std::nullopt;
  return in["board_shift"].get<unsigned>();
}

std::vector<Message> messages(const json& list) {
  std::vector<Message> out;
  for (const json& in : list) {
    out.push_back(
        {id_of(in["id"]), shift_of(in), in["bytes"].get<std::vector<std::uint8_t>>(), in["feature"]});
    if (!in.contains("control")) continue;
    const json& control = in["control"];
    out.back().control = UsbControl{control["type"], control["request"], control["value"], control["index"],
                                    control["length"]};
  }
  return out;
}

WrappingNumber wrapping_number(const json& in) {
  const NumberType type = wire::number_type(in["type"].get<std::string>());
  return {in["offset"], type.bytes, type.big_endian, in.value("unit_us", 1.0) * 1e3};
}

SensorClass class_of(const std::string& name) {
  return name == "array3"   ? SensorClass::array3
         : name == "wrench" ? SensorClass::wrench
                            : SensorClass::normal;
}

TaxelLayout layout_of(const json& in, SensorClass sensor_class, std::vector<Problem>& problems) {
  TaxelLayout usual = TaxelLayout::wrench(0.01);
  const bool one = sensor_class == SensorClass::wrench;
  const auto add = [&](const std::string& what) { problems.push_back(problem_of("/layout", in, what)); };
  if (one != in.contains("wrench_mm") || in.contains("grid") != in.contains("pitch_mm") ||
      in.contains("grid") + in.contains("taxels") + in.contains("wrench_mm") != 1) {
    add(one ? "a wrench needs wrench_mm and nothing else" : "expected grid with pitch_mm, or taxels");
    return usual;
  }
  if (one) return TaxelLayout::wrench(in["wrench_mm"].get<double>() * kMetresPerMm);
  try {
    if (in.contains("grid"))
      return TaxelLayout::grid(in["grid"][0], in["grid"][1], in["pitch_mm"].get<double>() * kMetresPerMm);
    std::vector<double> x_m, y_m;
    for (const json& taxel : in["taxels"]) {
      x_m.push_back(taxel[0].get<double>() * kMetresPerMm);
      y_m.push_back(taxel[1].get<double>() * kMetresPerMm);
    }
    return TaxelLayout::scattered(std::move(x_m), std::move(y_m));
  } catch (const std::invalid_argument& error) {
    add(error.what());
    return usual;
  }
}

SkinInfo skin_of(const json& in) {
  const json& radius = in["radius_mm"];
  return {radius.is_string() ? std::numeric_limits<double>::infinity() : radius.get<double>() * kMetresPerMm,
          in["modulus_mpa"].get<double>() * 1e6, in["poisson"].get<double>(),
          in["depth_mm"].get<double>() * kMetresPerMm, skin_base_of(in["base"].get<std::string>())};
}

// The channel and sign of a device's axis; nothing for an axis that the profile's `axes` does not name.
struct Axis {
  Channel channel;
  double sign;
};

std::optional<Axis> axis_of(const json& axes, char device_axis) {
  for (const auto& [key, channel] :
       {std::pair{"normal", Channel::normal}, {"x", Channel::shear_x}, {"y", Channel::shear_y}}) {
    const auto from = axes[key].get<std::string>();
    if (from.back() == device_axis) return Axis{channel, from[0] == '-' ? -1.0 : 1.0};
  }
  return std::nullopt;
}

HidMatch device_of(const json& in) {
  return {static_cast<std::uint16_t>(id_of(in["vendor"])), static_cast<std::uint16_t>(id_of(in["product"])),
          0};
}

UsbMatch usb_of(const json& in) {
  UsbMatch out;
  for (const json& device : in["devices"]) out.devices.push_back(device_of(device));
  out.interface = in["interface"];
  out.in = static_cast<std::uint8_t>(id_of(in["in"]));
  out.out = static_cast<std::uint8_t>(id_of(in["out"]));
  if (in.contains("serial_port")) {
    out.cdc_interface = in["serial_port"]["interface"].get<int>();
    out.baud = in["serial_port"]["baud"];
  }
  return out;
}

SerialLine serial_of(const json& in) {
  SerialLine out;
  out.baud = in["baud"];
  out.parity = in["parity"] == "none" ? 'N' : in["parity"] == "even" ? 'E' : 'O';
  out.stop_bits = in["stop_bits"];
  out.rts_cts = in["flow"] == "rts_cts";
  out.rs485 = in["rs485"];
  out.silence_ns = static_cast<std::int64_t>(in["silence_ms"].get<double>() * 1e6);
  for (const json& request : in["poll"])
    out.poll.push_back({request["bytes"].get<std::vector<std::uint8_t>>(),
                        static_cast<std::int64_t>(request["answer_ms"].get<double>() * 1e6)});
  return out;
}

Checksum checksum_of(const json& in) {
  static const std::map<std::string, ChecksumKind> kKinds{{"sum8", ChecksumKind::sum8},
                                                          {"xor8", ChecksumKind::xor8},
                                                          {"lrc8", ChecksumKind::lrc8},
                                                          {"sum16le", ChecksumKind::sum16le},
                                                          {"sum16be", ChecksumKind::sum16be},
                                                          {"crc8", ChecksumKind::crc8},
                                                          {"crc16modbus", ChecksumKind::crc16modbus},
                                                          {"crc16xmodem", ChecksumKind::crc16xmodem}};
  return {kKinds.at(in["kind"]), in["at"], in["from"], in["to"]};
}

Stream stream_of(const json& in, std::vector<Problem>& problems) {
  Stream out;
  out.begin = in["begin"].get<std::vector<std::uint8_t>>();
  out.end = in["end"].get<std::vector<std::uint8_t>>();
  out.longest = in["longest"];
  if (in.contains("length")) out.length = out.longest = in["length"];
  if (in.contains("length_byte")) out.length_byte = {in["length_byte"]["offset"], in["length_byte"]["plus"]};
  if (in.contains("length") + in.contains("length_byte") > 1 ||
      (in.contains("length") + in.contains("length_byte") == 0 && out.end.empty())) {
    problems.push_back(problem_of("/stream", in, "expected length, or length_byte, or an end marker"));
  }
  if (in.contains("checksum")) out.checksum = checksum_of(in["checksum"]);
  out.pts2 = in["inside"] == "pts2";
  if (in["inside"] == "csv") out.csv_values = in["values"];
  if (in.contains("records")) {
    out.records_from = in["records"]["from"];
    for (const json& record : in["records"]["kinds"])
      out.records.push_back({record["tag"], record["mask"], record["bytes"]});
  }
  return out;
}

class ScanConverter {
 public:
  ScanConverter(const json& in, const Profile& profile, std::vector<Problem>& problems)
      : in_(in), profile_(profile), problems_(problems) {}

  std::vector<PacketRule> rules() {
    const json& scan = in_["scan"];
    std::vector<PacketRule> out;
    for (unsigned turn = 0; turn < scan["repeat"].get<unsigned>(); ++turn) {
      for (std::size_t i = 0; i < scan["packets"].size(); ++i) {
        const json& packet = scan["packets"][i];
        PacketRule& rule = out.emplace_back();
        rule.id = id_of(packet["id"]) + turn * scan["id_step"].get<unsigned>();
        rule.board_shift = shift_of(packet);
        rule.length = packet["length"];
        if (packet.contains("match")) {
          const json& match = packet["match"];
          rule.match = {match["offset"], match["mask"], match["value"]};
        }
        if (packet.contains("clock")) rule.clock = wrapping_number(packet["clock"]);
        if (packet.contains("counter")) rule.counter = wrapping_number(packet["counter"]);
        for (std::size_t j = 0; j < packet["fields"].size(); ++j) {
          fields(packet["fields"][j], turn * scan["taxels_each"].get<std::size_t>(),
                 pointer_to(pointer_to("/scan/packets", i) + "/fields", j), turn == 0, rule.fields);
        }
      }
    }
    return out;
  }

 private:
  void fields(const json& in, std::size_t first_taxel, const std::string& at, bool tell,
              std::vector<Field>& out) {
    if (in.contains("usage")) return by_usage(in, first_taxel, at, tell, out);
    if (!in.contains("offset") || !in.contains("type")) {
      if (tell) problems_.push_back(problem_of(at, in, "expected offset and type, or usage"));
      return;
    }
    if (in.contains("scale_pa") == in.contains("scale_n")) {
      if (tell) problems_.push_back(problem_of(at, in, "expected either scale_pa or scale_n"));
      return;
    }
    const auto axis = axis_of(in_["axes"], in["axis"].get<std::string>()[0]);
    if (!axis) {
      if (tell) problems_.push_back(problem_of(at + "/axis", in["axis"], "is not among the axes"));
      return;
    }
    Field field;
    field.sensor = in["sensor"];
    field.channel = axis->channel;
    field.type = wire::number_type(in["type"].get<std::string>());
    field.zero = in["zero"];
    const double gain_pa =
        axis->sign * (in.contains("scale_pa") ? in["scale_pa"].get<double>()
                                              : in["scale_n"].get<double>() / profile_.layout.area_m2());
    const auto stride = in["stride"].get<std::size_t>();
    for (std::size_t i = 0; i < in["count"].get<std::size_t>(); ++i) {
      field.taxel = first_taxel + in["taxel"].get<std::size_t>() + i;
      field.gain_pa = gain_pa * gain_of(field.taxel);
      field.offset = in["offset"].get<std::size_t>() + i * (stride == 0 ? field.type.bytes : stride);
      out.push_back(field);
    }
  }

  double gain_of(std::size_t taxel) const {
    const auto gain = in_.find("gain");
    return gain != in_.end() && taxel < gain->size() ? (*gain)[taxel].get<double>() : 1;
  }

  // The device's descriptor gives place, type and scale; the gain multiplies that scale.
  void by_usage(const json& in, std::size_t first_taxel, const std::string& at, bool tell,
                std::vector<Field>& out) {
    const auto axis = axis_of(in_["axes"], in["axis"].get<std::string>()[0]);
    if (!axis || in["count"] != 1 || in.contains("offset") || in_["driver"] != "hid") {
      if (tell)
        problems_.push_back(problem_of(
            at, in, "a usage is for driver hid, one value, an axis among the axes, and needs no offset"));
      return;
    }
    Field field;
    field.sensor = in["sensor"];
    field.channel = axis->channel;
    field.taxel = first_taxel + in["taxel"].get<std::size_t>();
    field.gain_pa = axis->sign * gain_of(field.taxel);
    field.usage = id_of(in["usage"]);
    out.push_back(field);
  }

  const json& in_;
  const Profile& profile_;
  std::vector<Problem>& problems_;
};

}  // namespace

Profile converted(const json& in, std::vector<Problem>& problems) {
  Profile out;
  out.description = in["description"];
  out.tested = in["tested"];
  out.driver = in["driver"];
  out.sensor_class = class_of(in["class"]);
  out.rate_hz = in["rate_hz"];
  out.sensors = in["sensors"];
  out.zeroed = in["zeroed"];
  out.calibrated = in["calibrated"];
  out.layout = layout_of(in["layout"], out.sensor_class, problems);
  if (in.contains("gain") && in["gain"].size() != out.layout.size()) {
    problems.push_back(problem_of("/gain", in["gain"],
                                  "has " + std::to_string(in["gain"].size()) +
                                      " values; expected one for each of the " +
                                      std::to_string(out.layout.size()) + " taxels"));
  }
  out.skin = skin_of(in["skin"]);
  out.scan_timeout_ns = std::llround(in["scan"]["timeout_ms"].get<double>() * 1e6);
  out.scan = ScanConverter(in, out, problems).rules();
  out.start = messages(in["start"]);
  out.stop = messages(in["stop"]);
  out.keep_alive_ns = in["keep_alive_ms"].get<std::int64_t>() * 1'000'000;
  if (in["scan"].contains("key_offset")) out.key_offset = in["scan"]["key_offset"].get<std::size_t>();
  if (in.contains("hid")) {
    out.hid = device_of(in["hid"]);
    out.hid->usage = id_of(in["hid"]["usage"]);
    if (out.hid->vendor == 0 && out.hid->usage == 0)
      problems.push_back(problem_of("/hid", in["hid"], "matches every keyboard; expected vendor or usage"));
  }
  if (in.contains("stream")) out.stream = stream_of(in["stream"], problems);
  if (in.contains("usb")) out.usb = usb_of(in["usb"]);
  if (in.contains("serial")) out.serial = serial_of(in["serial"]);
  if (in.contains("modbus")) {
    const json& map = in["modbus"];
    const auto parity = map["parity"].get<std::string>();
    out.modbus = ModbusMap{map["unit"], map["function"], map["tcp_port"], map["baud"],
                           parity == "none"   ? 'N'
                           : parity == "even" ? 'E'
                                              : 'O'};
  }
  return out;
}

}  // namespace slipd::decode
