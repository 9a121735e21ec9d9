// The checks of a profile that a JSON Schema cannot express.
#include <nlohmann/json.hpp>

#include "drivers/decode/checksum.hpp"
#include "drivers/decode/profile_parts.hpp"
#include "drivers/decode/pts2.hpp"

namespace slipd::decode {
namespace {

using nlohmann::json;

constexpr std::size_t kCanFdBytes = 64;
constexpr std::size_t kReportBytes = 255;
constexpr std::size_t kMostRegisters = 125;  // of one Modbus request
constexpr std::size_t kMostPackets = 4096;   // of one scan
constexpr std::uint32_t kLargestCanId = 0x1FFFFFFF, kLargestRegister = 65535;
constexpr std::uint32_t kLargestByteId = 255;  // report ids and tags

const char* word(Channel channel) {
  return channel == Channel::normal ? "normal" : channel == Channel::shear_x ? "x" : "y";
}

class Finder {
 public:
  Finder(const json& in, const Profile& profile, std::vector<Problem>& problems)
      : in_(in), profile_(profile), problems_(problems), packets_(in["scan"]["packets"].size()) {}

  void find() {
    timing();
    if (profile_.scan.size() > kMostPackets) {
      add("/scan/repeat", in_["scan"]["repeat"], "makes more than 4096 packets a scan");
      return;
    }
    for (std::size_t i = 0; i < packets_; ++i) packet(profile_.scan[i], pointer_to("/scan/packets", i));
    ids();
    messages("/start", profile_.start);
    messages("/stop", profile_.stop);
    told_apart();
    if (problems_.empty()) every_taxel_once();
    if (profile_.driver == "modbus") registers();
    if ((profile_.driver == "hid" && !profile_.hid) || (profile_.driver == "usb" && !profile_.usb) ||
        (profile_.driver == "serial" && !profile_.serial))
      problems_.push_back({"/" + profile_.driver, "", "is missing; the driver needs it"});
    stream();
  }

 private:
  void add(const std::string& pointer, const json& value, const std::string& what) {
    problems_.push_back(problem_of(pointer, value, what));
  }

  void timing() {
    if (static_cast<double>(profile_.scan_timeout_ns) * profile_.rate_hz < 1e9) return;
    add("/scan/timeout_ms", in_["scan"]["timeout_ms"],
        "is not shorter than from scan to scan at rate_hz: halves of two scans could be taken for one");
  }

  void packet(const PacketRule& rule, const std::string& at) {
    if (profile_.driver == "can" && rule.length > kCanFdBytes)
      add(at + "/length", rule.length, "is more than a CAN frame holds; expected up to 64 bytes");
    if (profile_.driver == "hid" && rule.length > kReportBytes)
      add(at + "/length", rule.length, "is more than a report holds; expected up to 255 bytes");
    if ((rule.match.value & ~unsigned{rule.match.mask}) != 0)
      add(at + "/match/value", rule.match.value,
          "has bits outside the mask " + std::to_string(rule.match.mask) +
              ", so no packet has it: clear them, or widen the mask");
    find_misplaced(profile_, rule, at, problems_);
  }

  std::uint32_t largest_id() const {
    return profile_.driver == "can"      ? kLargestCanId
           : profile_.driver == "modbus" ? kLargestRegister
                                         : kLargestByteId;
  }

  void ids() {
    for (std::size_t i = 0; i < profile_.scan.size(); ++i) {
      if (profile_.scan[i].id <= largest_id()) continue;
      add(pointer_to("/scan/packets", i % packets_) + "/id", profile_.scan[i].id,
          "is the id in repetition " + std::to_string(i / packets_) + "; driver " + profile_.driver +
              " has ids up to " + std::to_string(largest_id()) + ": lower the id or id_step");
      return;
    }
  }

  void messages(const std::string& at, const std::vector<Message>& messages) {
    for (std::size_t i = 0; i < messages.size(); ++i) {
      if (profile_.driver == "hid" && messages[i].id > kLargestByteId)
        add(pointer_to(at, i) + "/id", messages[i].id, "is no report id; expected up to 255");
      if (profile_.driver == "usb" && profile_.usb && profile_.usb->out == 0 && !messages[i].control)
        problems_.push_back({pointer_to(at, i), "",
                             "has no endpoint to go to: name the device's in usb.out, or use control"});
    }
  }

  // The packets that the stream produces must be those of the scan.
  void stream() {
    if (profile_.driver == "serial" && profile_.serial) {
      const bool silence = profile_.serial->silence_ns > 0;
      if (silence == profile_.stream.has_value())
        problems_.push_back(
            {"/serial/silence_ms", "", "packets end by silence, or as stream says; expected one of both"});
    }
    if (!profile_.stream) return;
    const Stream& rule = *profile_.stream;
    const json& in = in_["stream"];
    if (profile_.driver != "usb" && profile_.driver != "serial")
      add("/stream", in, "is for drivers usb and serial; others bring packets");
    if (rule.begin.empty() && rule.end.empty())
      add("/stream/begin", in["begin"], "is empty, and so is end; nothing would say where frames begin");
    if (rule.begin.size() + rule.end.size() > rule.longest)
      add(rule.length != 0 ? "/stream/length" : "/stream/longest", rule.longest,
          "is shorter than begin and end together: correct it, or the markers");
    if (rule.checksum.kind != ChecksumKind::none && !place_of(rule.checksum, rule.longest))
      add("/stream/checksum", in["checksum"],
          "reaches out of a frame of " + std::to_string(rule.longest) + " bytes: correct at, from or to");
    if (rule.csv_values != 0 && !rule.records.empty())
      add("/stream/records", in["records"], "cannot be inside csv");
    if (rule.length_byte.plus != 0 && rule.length_byte.offset >= rule.longest)
      add("/stream/length_byte/offset", rule.length_byte.offset, "lies behind the longest frame's end");
    if (rule.pts2 && !rule.records.empty()) add("/stream/records", in["records"], "cannot be inside pts2");
    for (std::size_t i = 0; i < packets_; ++i) {
      const PacketRule& packet = profile_.scan[i];
      const std::size_t wanted = cut_size(rule, packet);
      if (wanted == 0 || wanted == packet.length) continue;
      add(pointer_to("/scan/packets", i) + "/length", packet.length,
          wanted == kNone ? "is of a packet that is no record: none has its id for a tag"
                          : "is not what the stream brings: " + std::to_string(wanted) + " bytes");
    }
  }

  static constexpr std::size_t kNone = SIZE_MAX;

  // The size of the packet that the stream produces; 0: any, kNone: it produces no such packet.
  std::size_t cut_size(const Stream& rule, const PacketRule& packet) const {
    if (rule.csv_values != 0) return rule.csv_values * sizeof(double);
    if (rule.pts2) return kPts2Head + profile_.sensors * profile_.layout.size() * kPts2Pillar;
    if (rule.records.empty()) return rule.length;
    for (const Record& record : rule.records)
      if ((packet.id & record.mask) == record.tag) return record.bytes;
    return kNone;
  }

  void told_apart() {
    if (packets_ == 0) return;
    for (std::size_t i = 0; i < profile_.scan.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const PacketRule &a = profile_.scan[i], &b = profile_.scan[j];
        if (a.id != b.id) continue;
        const bool differ = a.match.mask != 0 && a.match.offset == b.match.offset &&
                            ((a.match.value ^ b.match.value) & a.match.mask & b.match.mask) != 0;
        if (differ) continue;
        add(pointer_to("/scan/packets", i % packets_), in_["scan"]["packets"][i % packets_]["id"],
            "is the id of another packet of the scan with nothing to tell them apart; use id_step or match");
        return;
      }
    }
  }

  void every_taxel_once() {
    const std::size_t taxels = profile_.layout.size();
    std::vector<int> filled(profile_.sensors * taxels * 3, 0);
    const auto at = [&](std::size_t sensor, std::size_t taxel, Channel channel) -> int& {
      return filled[(sensor * taxels + taxel) * 3 + static_cast<std::size_t>(channel)];
    };
    const auto name = [&](std::size_t sensor, std::size_t taxel, Channel channel) {
      return "taxel " + std::to_string(taxel) +
             (profile_.sensors > 1 ? " of sensor " + std::to_string(sensor) : "") + ", " + word(channel) +
             ", ";
    };
    for (const PacketRule& rule : profile_.scan) {
      for (const Field& field : rule.fields) {
        if (field.taxel >= taxels) {
          add("/layout", in_["layout"],
              "has " + std::to_string(taxels) + " taxels, and a field speaks of taxel " +
                  std::to_string(field.taxel) + ", which has no position");
          return;
        }
        if (at(field.sensor, field.taxel, field.channel)++ > 0) {
          problems_.push_back({"/scan", "", name(field.sensor, field.taxel, field.channel) + "comes twice"});
          return;
        }
      }
    }
    for (std::size_t sensor = 0; sensor < profile_.sensors; ++sensor) {
      for (std::size_t taxel = 0; taxel < taxels; ++taxel) {
        for (const Channel channel : {Channel::normal, Channel::shear_x, Channel::shear_y}) {
          const bool wanted = channel == Channel::normal || profile_.sensor_class != SensorClass::normal;
          if ((at(sensor, taxel, channel) > 0) == wanted) continue;
          problems_.push_back(
              {"/scan", "",
               name(sensor, taxel, channel) +
                   (wanted ? "never comes" : "comes, but the class says that there is none")});
          return;
        }
      }
    }
  }

  void registers() {
    if (!profile_.modbus) {
      problems_.push_back({"/modbus", "", "is missing; the driver needs it"});
      return;
    }
    const auto there = in_["modbus"]["registers"].get<std::size_t>();
    for (std::size_t i = 0; i < packets_; ++i) {
      const PacketRule& rule = profile_.scan[i];
      const std::string at = pointer_to("/scan/packets", i);
      if (rule.length % 2 != 0) add(at + "/length", rule.length, "is no whole number of registers");
      if (rule.length / 2 > kMostRegisters)
        add(at + "/length", rule.length, "is more than one request can have");
    }
    for (const PacketRule& rule : profile_.scan) {
      if (rule.id + rule.length / 2 <= there) continue;
      add("/modbus/registers", there,
          "is all that the device has, but a packet ends with register " +
              std::to_string(rule.id + rule.length / 2 - 1));
      return;
    }
  }

  const json& in_;
  const Profile& profile_;
  std::vector<Problem>& problems_;
  std::size_t packets_;
};

}  // namespace

void find_misplaced(const Profile& profile, const PacketRule& rule, const std::string& at,
                    std::vector<Problem>& problems) {
  const auto add = [&](const std::string& pointer, const json& value, const std::string& what) {
    problems.push_back(problem_of(pointer, value, what));
  };
  for (const auto& number : {rule.clock, rule.counter}) {
    if (number && number->offset + number->bytes > rule.length)
      add(at, number->offset, "is where a clock or counter stands, which reaches behind the packet's end");
  }
  if (profile.key_offset && *profile.key_offset >= rule.length)
    add("/scan/key_offset", *profile.key_offset, "lies behind the end of " + at);
  if (rule.match.mask != 0 && rule.match.offset >= rule.length)
    add(at + "/match/offset", rule.match.offset, "lies behind the packet's end");
  std::vector<int> owner(rule.length, 0);
  for (const Field& field : rule.fields) {
    if (field.sensor >= profile.sensors) {
      add(at + "/fields", field.sensor,
          "is no sensor of the device; it has " + std::to_string(profile.sensors));
      return;
    }
    if (field.usage != 0) continue;  // the device's descriptor gives its place
    for (std::size_t byte = field.offset; byte < field.offset + field.type.bytes; ++byte) {
      if (byte >= rule.length) {
        add(at + "/fields", byte, "is a byte behind the packet's end; it has " + std::to_string(rule.length));
        return;
      }
      if (owner[byte]++ > 0) {
        add(at + "/fields", byte, "is a byte of two fields, which overlap");
        return;
      }
    }
  }
}

void find_contradictions(const json& in, const Profile& profile, std::vector<Problem>& problems) {
  Finder(in, profile, problems).find();
}

}  // namespace slipd::decode
