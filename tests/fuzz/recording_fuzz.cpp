// Any bytes as a recording: it is refused with a message, or gives a header and frames, the same after a
// rewind, up to the end or to a reported fault.
#include <optional>

#include "core/recording/recording.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/fuzz/file_of.hpp"

namespace {

using namespace slipd;
using fuzz::demand;
using Status = RecordingReader::Status;

constexpr std::size_t kMostTaxels = 4096;  // larger ones are slow, not different

std::uint64_t play(RecordingReader& reader, FrameSlot& slot) {
  std::uint64_t frames = 0;
  std::optional<RecordedEstimate> estimate;
  Status status = reader.next(slot, &estimate);
  for (; status != Status::end && status != Status::damaged; status = reader.next(slot, &estimate)) {
    if (status == Status::frame) ++frames;
  }
  demand(reader.next(slot) == status);  // and does not change
  demand(reader.fault().empty() != reader.has_fault());
  demand(status != Status::damaged || reader.has_fault());
  return frames;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    RecordingReader reader(fuzz::file_of(data, size));
    const std::size_t taxels = reader.header().layout.size();
    if (taxels > kMostTaxels) return 0;
    test::OwnedSlot own(taxels);
    const std::uint64_t frames = play(reader, own.slot);
    demand(frames * (12 * taxels + 8) <= size);
    reader.rewind();
    demand(play(reader, own.slot) == frames);
  } catch (const RecordingError& error) {
    demand(error.offset() <= size && *error.what() != '\0');
  }
  return 0;
}
