// Any datagrams and texts that reach slipd-feed: each is a frame of as many finite numbers as the sensor has,
// or none. Input: a byte that chooses the profile, then messages, each behind two bytes of its length.
#include <cmath>

#include "bridges/feed/assembler.hpp"
#include "bridges/feed/reader.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace slipd::feed;
using slipd::fuzz::demand;

constexpr std::size_t kTaxels = 2;

Profile shipped(const std::string& name, const std::string& device) {
  return find_profile(SLIPD_SOURCE_DIR "/config/feeds/" + name + ".json", {device, kTaxels});
}

Bytes next(Bytes& in) {
  const std::size_t wanted = in[0] + 256U * in[1];
  const Bytes message = in.subspan(2, std::min(wanted, in.size() - 2));
  in = in.subspan(2 + message.size());
  return message;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Profile kProfiles[] = {shipped("tac3d", "A"), shipped("xela-server", "1"),
                                      shipped("xela-server-raw", "1")};
  Bytes in(data, size);
  if (in.empty()) return 0;
  const Profile& profile = kProfiles[in[0] % std::size(kProfiles)];
  Reader reader(profile);
  Assembler assembler(profile.datagrams.value_or(Datagrams{}), profile.format == Format::yaml_head);
  in = in.subspan(1);
  while (in.size() > 2) {
    Message message{{}, next(in)};
    if (profile.datagrams && assembler.put("sender", message.body, message) != Assembler::Result::message)
      continue;
    Reading reading;
    if (reader.read(message, reading) != Outcome::frame) {
      demand(!reader.why().empty());
      continue;
    }
    demand(reading.values.size() == 3 * kTaxels);
    for (const float value : reading.values) demand(std::isfinite(value));
    demand(!reading.sent_s || std::isfinite(*reading.sent_s));
  }
  return 0;
}
