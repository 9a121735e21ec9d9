// Any text as a profile: it is refused with a message, or accepted; an accepted profile then decodes a few
// bytes.
#include <array>
#include <cstdint>
#include <string>

#include "drivers/decode/decoder.hpp"
#include "drivers/decode/framer.hpp"

namespace {

using namespace slipd;

constexpr std::size_t kMostTaxels = 4096;  // larger ones are slow, not different

void try_out(const decode::Profile& profile) {
  if (profile.layout.size() > kMostTaxels) return;
  decode::Framer framer(profile);
  decode::Decoder decoder(profile, 0, 1);
  std::vector<float> memory(3 * profile.layout.size());
  FrameSlot slot;
  slot.normal_pa = std::span(memory).first(profile.layout.size());
  slot.shear_x_pa = std::span(memory).subspan(profile.layout.size(), profile.layout.size());
  slot.shear_y_pa = std::span(memory).last(profile.layout.size());
  std::array<std::uint8_t, 4096> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 7);
  for (const decode::PacketRule& rule : decoder.rules())
    decoder.take(rule.id, std::span(bytes).first(std::min(rule.length, bytes.size())), 0, slot);
  framer.put(bytes);
  decode::RawPacket packet;
  while (framer.next(packet) != decode::Framer::Result::incomplete)
    decoder.take(packet.id, packet.bytes, 0, slot);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    try_out(decode::parse_profile(std::string(data, data + size), "fuzzed"));
  } catch (const DriverError&) {
    // the expected refusal
  }
  return 0;
}
