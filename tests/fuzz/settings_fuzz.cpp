// Any text as a configuration: it gives usable settings, or problems of one printable line each that name
// the file.
#include <cstdint>

#include "tests/config/support.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace slipd;
using fuzz::demand;

void use(const Settings& settings) {
  for (const SensorSettings& sensor : settings.sensors) {
    demand(!sensor.setup.name.empty() && sensor.setup.layout.size() > 0);
    static_cast<void>(settings.scene_of(sensor));
  }
  for (const GraspSettings& grasp : settings.grasps) demand(!grasp.sensors.empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    use(test::parse(std::string(data, data + size)));
  } catch (const SettingsError& error) {
    demand(!error.problems().empty());
    for (const std::string& line : error.problems()) {
      demand(line.starts_with("t.json:"));
      for (const char c : line) demand(static_cast<unsigned char>(c) >= ' ' && c != '\x7f');
    }
  }
  return 0;
}
