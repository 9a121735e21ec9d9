#include "tools/slipctl/decode.hpp"

#include <array>
#include <cmath>
#include <istream>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>

#include "drivers/decode/decoder.hpp"
#include "drivers/decode/framer.hpp"

namespace slipctl {
namespace {

using namespace slipd;
using Bytes = std::vector<std::uint8_t>;

// One of the device's sensors, with its slot.
struct Sensor {
  Sensor(const decode::Profile& profile, std::size_t number, unsigned board)
      : decoder(profile, number, board), memory(3 * profile.layout.size()) {
    const std::size_t taxels = profile.layout.size();
    slot.normal_pa = std::span(memory).first(taxels);
    slot.shear_x_pa = std::span(memory).subspan(taxels, taxels);
    slot.shear_y_pa = std::span(memory).last(taxels);
  }
  decode::Decoder decoder;
  std::vector<float> memory;
  FrameSlot slot;
};

class Capture {
 public:
  Capture(const DecodeOptions& options, std::ostream& out)
      : json_(options.json), out_(out), profile_(decode::find_profile(options.profile)), framer_(profile_) {
    for (std::size_t i = 0; i < profile_.sensors; ++i) sensors_.emplace_back(profile_, i, options.board);
  }

  void read(std::istream& in) {
    if (profile_.driver == "can") return read_candump(in);
    Bytes bytes(std::istreambuf_iterator<char>(in), {});
    if (profile_.stream) return read_stream(bytes);
    read_packets(bytes);
  }

  std::uint64_t frames() const { return frames_; }

  void remark(std::ostream& remarks) const {
    remarks << frames_ << " frames, " << dropped_ << " dropped";
    if (foreign_ > 0) remarks << ", " << foreign_ << " packets of no sensor";
    if (profile_.stream) remarks << ", " << framer_.counts().garbage << " bytes of no frame";
    remarks << '\n';
  }

 private:
  // (1436509052.249713) can0 710#00754975247549
  void read_candump(std::istream& in) {
    for (std::string line; std::getline(in, line);) {
      const std::size_t hash = line.find('#');
      const std::size_t blank = line.rfind(' ', hash);
      if (hash == std::string::npos) continue;
      try {
        const std::size_t from = blank == std::string::npos ? 0 : blank + 1;
        const auto id = static_cast<std::uint32_t>(std::stoul(line.substr(from, hash - from), nullptr, 16));
        Bytes bytes;
        for (std::size_t at = hash + 1;
             at + 1 < line.size() && std::isxdigit(static_cast<unsigned char>(line[at])) != 0; at += 2) {
          bytes.push_back(static_cast<std::uint8_t>(std::stoul(line.substr(at, 2), nullptr, 16)));
        }
        const double seconds = line.starts_with('(') ? std::stod(line.substr(1)) : 0;
        take(id, bytes, static_cast<std::int64_t>(seconds * 1e9));
      } catch (const std::logic_error&) {
        ++dropped_;  // a malformed number
      }
    }
  }

  void read_stream(const Bytes& bytes) {
    for (std::size_t at = 0; at < bytes.size(); at += std::min(bytes.size() - at, framer_.room())) {
      framer_.put(std::span(bytes).subspan(at, std::min(bytes.size() - at, framer_.room())));
      decode::RawPacket packet;
      for (auto got = framer_.next(packet); got != decode::Framer::Result::incomplete;
           got = framer_.next(packet)) {
        if (got == decode::Framer::Result::packet) take(packet.id, packet.bytes, 0);
        if (got == decode::Framer::Result::invalid) ++dropped_;
      }
    }
  }

  // Consecutive packets: reports that begin with their id where they have one, else of the scan's lengths.
  void read_packets(const Bytes& bytes) {
    const auto& rules = profile_.scan;
    const bool numbered = profile_.driver == "hid" && rules.front().id != 0;
    std::size_t turn = 0;
    for (std::size_t at = 0; at < bytes.size();) {
      const decode::PacketRule* rule = &rules[turn++ % rules.size()];
      if (numbered) {
        const auto found = std::ranges::find(rules, bytes[at], &decode::PacketRule::id);
        if (found == rules.end()) {  // of unknown length: skips the shortest
          ++foreign_;
          at += 1 + rules.front().length;
          continue;
        }
        rule = &*found;
        ++at;
      }
      const std::size_t size = std::min(rule->length, bytes.size() - at);
      take(rule->id, std::span(bytes).subspan(at, size), 0);
      at += size;
    }
  }

  void take(std::uint32_t id, std::span<const std::uint8_t> bytes, std::int64_t time_ns) {
    bool known = false;
    for (std::size_t i = 0; i < sensors_.size(); ++i) {
      switch (sensors_[i].decoder.take(id, bytes, time_ns, sensors_[i].slot)) {
        case decode::Outcome::foreign:
          continue;
        case decode::Outcome::partial:
          break;
        case decode::Outcome::dropped:
          ++dropped_;
          break;
        case decode::Outcome::frame:
          ++frames_;
          print(i);
      }
      known = true;
    }
    foreign_ += known ? 0 : 1;
  }

  void print(std::size_t number) {
    const FrameSlot& slot = sensors_[number].slot;
    if (json_) {
      nlohmann::ordered_json line{{"sensor", number}, {"seq", slot.sequence}, {"device_time_ns", nullptr}};
      if (slot.device_time_ns >= 0) line["device_time_ns"] = slot.device_time_ns;
      line["normal_pa"] = slot.normal_pa;
      line["shear_x_pa"] = slot.shear_x_pa;
      line["shear_y_pa"] = slot.shear_y_pa;
      out_ << line.dump() << '\n';
      return;
    }
    double normal_n = 0, x_n = 0, y_n = 0;
    for (std::size_t i = 0; i < slot.normal_pa.size(); ++i) {
      normal_n += slot.normal_pa[i] * profile_.layout.area_m2();
      x_n += slot.shear_x_pa[i] * profile_.layout.area_m2();
      y_n += slot.shear_y_pa[i] * profile_.layout.area_m2();
    }
    std::array<char, 160> line{};
    std::snprintf(line.data(), line.size(),
                  "sensor %zu  seq %llu  normal %.4g N  shear %.4g N (x %.4g, y %.4g)\n", number,
                  static_cast<unsigned long long>(slot.sequence), normal_n, std::hypot(x_n, y_n), x_n, y_n);
    out_ << line.data();
  }

  bool json_;
  std::ostream& out_;
  decode::Profile profile_;
  decode::Framer framer_;
  std::vector<Sensor> sensors_;
  std::uint64_t frames_ = 0, dropped_ = 0, foreign_ = 0;
};

}  // namespace

bool decode(const DecodeOptions& options, std::istream& in, std::ostream& out, std::ostream& remarks) {
  Capture capture(options, out);
  capture.read(in);
  capture.remark(remarks);
  return capture.frames() > 0;
}

}  // namespace slipctl
