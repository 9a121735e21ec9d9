// Any notices of a program whose frames are in shared memory, and anything that it does to this memory: a
// notice is a frame of finite numbers that were in the ring, with a rising sequence and time, or none, and no
// byte outside the ring is read. Input, repeated: a length, where in the ring (two bytes), as many bytes that
// are written there, a length (the highest bit: another message waits), the notice.
#include <sys/mman.h>

#include <algorithm>
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

constexpr std::size_t kValuesBytes = fuzz::kPushedTaxels * 3 * sizeof(float);

// The ring as its writer sees it.
class WritersRing {
 public:
  explicit WritersRing(const push::FrameRing& ring)
      : memory_(static_cast<std::uint8_t*>(
            mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_SHARED, ring.descriptor(), 0))) {
    demand(memory_ != MAP_FAILED);
  }
  WritersRing(const WritersRing&) = delete;
  WritersRing& operator=(const WritersRing&) = delete;
  ~WritersRing() { munmap(memory_, kBytes); }

  void write(std::size_t at, Bytes bytes) {
    const std::size_t from = at % kBytes;
    std::copy_n(bytes.begin(), std::min(bytes.size(), kBytes - from), memory_ + from);
  }

 private:
  static constexpr std::size_t kBytes = push_layout::ring_bytes(kValuesBytes);
  std::uint8_t* memory_;
};

Bytes taken_off(Bytes& in, std::size_t size) {
  const Bytes first = in.first(std::min(size, in.size()));
  in = in.subspan(first.size());
  return first;
}

std::size_t number(Bytes& in, std::size_t bytes) {
  std::size_t value = 0;
  for (const std::uint8_t byte : taken_off(in, bytes)) value = value << 8 | byte;
  return value;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const SensorSetup kSetup =
      test::setup_of(TaxelLayout::grid(2, 2, 0.001), nlohmann::json::object(), 100);
  push::Options options;
  options.max_age_ns = fuzz::kPushedMaxAgeNs;
  push::FrameReader reader(options.max_age_ns);
  reader.begin(push::agreement_without_hello(options, kSetup));
  push::FrameRing ring(kValuesBytes);
  demand(static_cast<bool>(ring));
  WritersRing writer(ring);
  fuzz::PushedFrames frames;
  Bytes in(data, size);
  for (std::int64_t now_ns = fuzz::kPushedStepNs; !in.empty(); now_ns += fuzz::kPushedStepNs) {
    const std::size_t written = number(in, 1);
    const std::size_t at = number(in, 2);
    writer.write(at, taken_off(in, written));
    const std::size_t length = number(in, 1);
    const Bytes notice = taken_off(in, length & 0x7FU);
    if (reader.take_from_ring(notice, ring, now_ns, (length & 0x80U) != 0, frames.slot()) !=
        push::Refusal::none)
      continue;
    frames.demand_next(now_ns);
  }
  return 0;
}
