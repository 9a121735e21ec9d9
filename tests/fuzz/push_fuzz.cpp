// Any messages of a program that pushes frames: a hello is accepted or refused with a text; a message is a
// frame of finite numbers with a rising sequence and time, or none. Input: messages, each behind a byte that
// is its length; the first is the hello, and where it is refused, frames are read as configured. Of the
// length's message the highest bit says that another one waits behind it.
#include <cstring>
#include <nlohmann/json.hpp>

#include "drivers/push/frame_reader.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/fuzz/demand.hpp"
#include "tests/fuzz/pushed_frames.hpp"

namespace {

using namespace slipd;
using fuzz::demand;
using Bytes = std::span<const std::uint8_t>;

Bytes next_message(Bytes& in, bool& waiting) {
  const std::size_t size = std::min<std::size_t>(in[0] & 0x7FU, in.size() - 1);
  waiting = (in[0] & 0x80U) != 0;
  const Bytes message = in.subspan(1, size);
  in = in.subspan(1 + size);
  return message;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const SensorSetup kSetup =
      test::setup_of(TaxelLayout::grid(2, 2, 0.001), nlohmann::json::object(), 100);
  push::Options options;
  options.max_age_ns = fuzz::kPushedMaxAgeNs;
  Bytes in(data, size);
  if (in.empty()) return 0;
  bool waiting = false;
  push::Agreement agreed = push::agreement_without_hello(options, kSetup);
  push::Text why{};
  if (push::agree(next_message(in, waiting), options, kSetup, agreed, why)) {
    demand(agreed.taxels == fuzz::kPushedTaxels && (agreed.axes == 1 || agreed.axes == 3));
    demand(agreed.calibrated || !agreed.zeroed);
  } else {
    demand(why.front() != 0 && std::memchr(why.data(), 0, why.size()) != nullptr);
  }
  push::FrameReader reader(options.max_age_ns);
  reader.begin(agreed);
  fuzz::PushedFrames frames;
  for (std::int64_t now_ns = fuzz::kPushedStepNs; !in.empty(); now_ns += fuzz::kPushedStepNs) {
    const Bytes message = next_message(in, waiting);
    if (reader.take(message, now_ns, waiting, frames.slot()) != push::Refusal::none) continue;
    frames.demand_next(now_ns);
  }
  return 0;
}
