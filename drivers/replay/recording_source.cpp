#include "drivers/replay/recording_source.hpp"

#include <cmath>
#include <cstdio>

namespace slipd::replay {
namespace {

std::string described(const TaxelLayout& layout) {
  char text[96];
  if (const auto& grid = layout.regular()) {
    std::snprintf(text, sizeof text, "{ \"grid\": [%zu, %zu], \"pitch_mm\": %.6g }", grid->columns,
                  grid->rows, 1e3 * grid->pitch_m);
  } else {
    std::snprintf(text, sizeof text, "%zu taxels, not in a grid", layout.size());
  }
  return text;
}

// Whether taxels have the same positions to a thousandth of their side: the configuration is in mm, a
// recording in m.
bool same_places(const TaxelLayout& a, const TaxelLayout& b) {
  if (a.size() != b.size()) return false;
  if (a.size() == 1) return true;  // one force vector: the configuration gives the pad's side
  const double near = 1e-3 * a.side_m();
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::hypot(a.x_m()[i] - b.x_m()[i], a.y_m()[i] - b.y_m()[i]) > near) return false;
  }
  return std::abs(a.side_m() - b.side_m()) <= near;
}

RecordingReader open_reader(const std::filesystem::path& file, const SensorSetup& sensor) {
  try {
    RecordingReader reader(file);
    const auto& recorded = reader.header().layout;
    if (!same_places(recorded, sensor.layout)) {
      throw DriverError(file.string() + ": recorded with a layout of " + described(recorded) +
                        ", but sensor \"" + sensor.name + "\" has " + described(sensor.layout) +
                        ": give the sensor the recording's layout");
    }
    return reader;
  } catch (const DriverError&) {
    throw;
  } catch (const std::exception& e) {
    throw DriverError(e.what());
  }
}

}  // namespace

RecordingSource::RecordingSource(const std::filesystem::path& file, const SensorSetup& sensor)
    : reader_(open_reader(file, sensor)) {}

ReadOutcome RecordingSource::next(FrameSlot& out) noexcept {
  switch (reader_.next(out)) {
    case RecordingReader::Status::frame:
      return ReadOutcome::frame;
    case RecordingReader::Status::skipped:
      return ReadOutcome::corrupt;
    case RecordingReader::Status::searching:
      return ReadOutcome::none;
    case RecordingReader::Status::end:
      return ReadOutcome::end;
    case RecordingReader::Status::damaged:
      break;
  }
  return ReadOutcome::damaged;
}

}  // namespace slipd::replay
