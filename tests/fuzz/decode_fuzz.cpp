// Any bytes, by any shipped profile: the decoder gives whole frames of finite numbers with rising sequence
// numbers, or none. The first byte selects the profile, the rest is the device's data. On USB a byte before
// each piece is its length. On other buses the data are packets (rule, length, bytes), a tenth of the scan's
// time-out apart.
#include <cmath>
#include <cstdint>
#include <map>

#include "drivers/decode/decoder.hpp"
#include "drivers/decode/framer.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace slipd;
using fuzz::demand;
using Bytes = std::span<const std::uint8_t>;

// In the order in which the profiles were added: files of the corpus select them by index.
constexpr const char* kNames[] = {"3dconnexion", "contactile-pts2", "icub-mtb",      "onrobot-rg2-ft",
                                  "optoforce",   "oymotion-rohand", "robotiq-ft300", "robotiq-tsf85",
                                  "takktile",    "vendor-hid-8x8",  "xela-xr1944",   "hid-force",
                                  "anyskin",     "paxini-l5325",    "csv-force"};

// The first sensor of a device.
class Device {
 public:
  explicit Device(const decode::Profile& profile)
      : profile_(profile), framer_(profile), decoder_(profile, 0, 1), memory_(3 * profile.layout.size()) {
    const std::size_t taxels = profile.layout.size();
    slot_.normal_pa = std::span(memory_).first(taxels);
    slot_.shear_x_pa = std::span(memory_).subspan(taxels, taxels);
    slot_.shear_y_pa = std::span(memory_).last(taxels);
  }

  void hear(Bytes in) {
    const bool stream = profile_.driver == "usb" || profile_.driver == "serial";
    while (in.size() > 2) in = stream ? piece(in) : packet(in);
  }

 private:
  Bytes piece(Bytes in) {
    const std::size_t size = std::min<std::size_t>(in[0], in.size() - 1);
    framer_.put(in.subspan(1, size));
    decode::RawPacket raw;
    for (auto got = framer_.next(raw); got != decode::Framer::Result::incomplete; got = framer_.next(raw)) {
      if (got == decode::Framer::Result::invalid) decoder_.mark_packet_lost();
      if (got == decode::Framer::Result::packet) take(raw.id, raw.bytes);
    }
    return in.subspan(1 + size);
  }

  Bytes packet(Bytes in) {
    const auto& rules = decoder_.rules();
    const std::size_t size = std::min<std::size_t>(in[1], in.size() - 2);
    take(rules[in[0] % rules.size()].id, in.subspan(2, size));
    return in.subspan(2 + size);
  }

  void take(std::uint32_t id, Bytes bytes) {
    now_ns_ += profile_.scan_timeout_ns / 10;
    if (decoder_.take(id, bytes, now_ns_, slot_) != decode::Outcome::frame) return;
    for (const float value : memory_) demand(std::isfinite(value));
    demand(slot_.sequence >= next_ && slot_.time_ns <= now_ns_);
    next_ = slot_.sequence + 1;
  }

  const decode::Profile& profile_;
  decode::Framer framer_;
  decode::Decoder decoder_;
  std::vector<float> memory_;
  FrameSlot slot_;
  std::int64_t now_ns_ = 0;
  std::uint64_t next_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<decode::Profile> kProfiles = [] {
    std::vector<decode::Profile> out;
    for (const char* name : kNames) out.push_back(decode::find_profile(name));
    return out;
  }();
  if (size == 0) return 0;
  Device device(kProfiles[data[0] % kProfiles.size()]);
  device.hear(Bytes(data, size).subspan(1));
  return 0;
}
