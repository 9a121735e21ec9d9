// Any bytes as a file for the driver replay, a recording or a CSV: it is refused with a message, or gives
// frames of finite numbers at rising times.
#include <cmath>
#include <nlohmann/json.hpp>

#include "drivers/replay/playlist.hpp"
#include "tests/drivers/driver_fixture.hpp"
#include "tests/fuzz/file_of.hpp"

namespace {

using namespace slipd;
using fuzz::demand;

constexpr int kFrames = 1000;  // of a file that is played in a loop

void play(replay::Playlist& playlist, FrameSlot& slot) {
  std::uint64_t last_sequence = 0;
  std::int64_t last_ns = 0;
  for (int i = 0; i < kFrames; ++i) {
    const replay::ReadOutcome next = playlist.next(slot);
    if (next == replay::ReadOutcome::damaged) return demand(!playlist.fault().empty());
    if (next == replay::ReadOutcome::end) return;
    if (next == replay::ReadOutcome::corrupt || next == replay::ReadOutcome::none) continue;
    for (const auto& axis : {slot.normal_pa, slot.shear_x_pa, slot.shear_y_pa}) {
      for (const float value : axis) demand(std::isfinite(value));
    }
    demand(last_ns == 0 || (slot.time_ns > last_ns && slot.sequence > last_sequence));
    last_ns = slot.time_ns;
    last_sequence = slot.sequence;
  }
}

}  // namespace

// The first byte: whether the file is played in a loop, and whether the sensor's rate is given.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const bool loop = (data[0] & 1U) != 0;
  const double rate_hz = (data[0] & 2U) != 0 ? 1000 : 0;
  try {
    const auto sensor = test::setup_of(TaxelLayout::grid(2, 1, 0.001), nlohmann::json::object(), rate_hz);
    replay::Options options{.file = fuzz::file_of(data + 1, size - 1),
                            .calibration = {.bias = std::vector<float>(6)}};
    options.loop = loop;
    replay::Playlist playlist(sensor, options);
    test::OwnedSlot own(2);
    play(playlist, own.slot);
  } catch (const DriverError& error) {
    demand(*error.what() != '\0');
  }
  return 0;
}
