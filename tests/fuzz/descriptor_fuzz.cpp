// Any bytes as a HID report descriptor: its fields lie within its reports. A profile that names a force by
// usage is refused with a message, or reads reports of the length that the descriptor states.
#include <algorithm>
#include <cmath>
#include <map>

#include "drivers/decode/decoder.hpp"
#include "drivers/hid/descriptor.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace slipd;
using fuzz::demand;

void read_reports(const decode::Profile& profile) {
  decode::Decoder decoder(profile, 0, 1);
  test::OwnedSlot own(profile.layout.size());
  for (const decode::PacketRule& rule : decoder.rules()) {
    const std::vector<std::uint8_t> report(rule.length, 0xA5);
    if (decoder.take(rule.id, report, 0, own.slot) != decode::Outcome::frame) continue;
    for (const float value : own.memory) demand(std::isfinite(value));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const decode::Profile kForce = decode::find_profile("hid-force");
  const std::span descriptor(data, size);
  std::map<std::uint8_t, std::size_t> ends;  // the end of each report's last field
  for (const hid::InputField& field : hid::input_fields(descriptor))
    ends[field.report] = std::max(ends[field.report], field.bit + field.bits);
  for (const auto& [report, bits] : ends) demand(bits <= 8 * hid::report_length(descriptor, report));
  try {
    decode::Profile profile = kForce;
    hid::resolve_usages(profile, descriptor);
    read_reports(profile);
  } catch (const DriverError& error) {
    demand(*error.what() != '\0');
  }
  return 0;
}
