#include "tests/support/replayed.hpp"

#include <vector>

#include "core/recording/recording.hpp"

namespace slipd::testing {

Replayed replay(const std::filesystem::path& file) try {
  Replayed found;
  RecordingReader reader(file);
  const std::size_t taxels = reader.header().layout.size();
  std::vector<float> memory(3 * taxels);
  const std::span all(memory);
  FrameSlot slot;
  slot.normal_pa = all.subspan(0, taxels);
  slot.shear_x_pa = all.subspan(taxels, taxels);
  slot.shear_y_pa = all.subspan(2 * taxels, taxels);
  while (reader.next_frame(slot) == RecordingReader::Status::frame) {
    found.in_order = found.in_order && (found.frames == 0 || slot.sequence > found.last_sequence);
    ++found.frames;
    found.last_sequence = slot.sequence;
  }
  found.fault = reader.fault();
  return found;
} catch (const std::exception& error) {
  return {.fault = error.what()};
}

}  // namespace slipd::testing
