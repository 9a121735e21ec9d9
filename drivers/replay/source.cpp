#include "drivers/replay/source.hpp"

#include <system_error>

#include "core/storage/buffered_file.hpp"
#include "drivers/replay/csv_source.hpp"
#include "drivers/replay/recording_source.hpp"

namespace slipd::replay {

std::unique_ptr<FrameSource> open_source(const std::filesystem::path& file, const SensorSetup& sensor) {
  bool text = false;
  try {
    BufferedFile look(file, 1);
    const auto first = look.peek(1);
    if (first.empty()) throw DriverError(file.string() + ": empty, expected a recording of slipd or CSV");
    text = first[0] < 0x80 ||
           first[0] == 0xEF;  // ASCII or a byte order mark; a CBOR map begins with 0xA0 to 0xBF
  } catch (const std::system_error& e) {
    throw DriverError(std::string(e.what()) + ": name a recording of slipd, a CSV, or a folder of them");
  }
  if (text) return std::make_unique<CsvSource>(file, sensor);
  return std::make_unique<RecordingSource>(file, sensor);
}

}  // namespace slipd::replay
