#include "drivers/replay/options.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace slipd::replay {
namespace {

std::vector<float> axis_values(const SensorSetup& sensor, const char* key, float otherwise, bool per_taxel) {
  const auto found = sensor.options.find(key);
  if (found == sensor.options.end()) return {otherwise, otherwise, otherwise};
  if (found->is_number()) {
    const auto value = found->get<float>();
    return {value, value, value};
  }
  auto values = found->get<std::vector<float>>();
  if (values.size() == 3 || (per_taxel && values.size() == 3 * sensor.layout.size())) return values;
  throw DriverError("sensor \"" + sensor.name + "\": replay's " + key + " has " +
                    std::to_string(values.size()) + " values: give one number, [x, y, z]" +
                    (per_taxel ? ", or x, y, z of each taxel in turn (" +
                                     std::to_string(3 * sensor.layout.size()) + " for this layout)"
                               : ""));
}

}  // namespace

Options parse_options(const SensorSetup& sensor) {
  Options options;
  options.file = sensor.options.value("file", "");
  if (options.file.empty()) {
    throw DriverError("sensor \"" + sensor.name +
                      "\": replay needs a file: a recording, a CSV, or a folder of them");
  }
  options.speed = sensor.options.value("speed", 1.0);
  options.loop = sensor.options.value("loop", false);
  const auto scale = axis_values(sensor, "scale", 1, false);
  options.calibration.scale = {scale[0], scale[1], scale[2]};
  const std::string unit = sensor.options.value("unit", "Pa");
  options.raw = unit == "raw";
  options.zero_from_s = sensor.options.value("zero_from_s", 0.0);
  if (unit == "N") {
    for (float& each : options.calibration.scale) each /= static_cast<float>(sensor.layout.area_m2());
  }
  const auto bias = axis_values(sensor, "bias", 0, true);
  options.calibration.bias.resize(3 * sensor.layout.size());
  for (std::size_t i = 0; i < options.calibration.bias.size(); ++i) {
    options.calibration.bias[i] = bias[i % bias.size()];
  }
  return options;
}

std::vector<std::string> taxel_names(const SensorSetup& sensor) {
  const std::size_t taxels = sensor.layout.size();
  const auto given = sensor.options.find("taxels");
  std::vector<std::string> names;
  if (given == sensor.options.end()) {
    for (std::size_t i = 1; i <= taxels; ++i) names.push_back("txl" + std::to_string(i));
    return names;
  }
  names = given->get<std::vector<std::string>>();
  const std::string who = "sensor \"" + sensor.name + "\": replay's taxels ";
  if (names.size() != taxels) {
    throw DriverError(who + "has " + std::to_string(names.size()) + " names: give one for each of the " +
                      std::to_string(taxels) + " taxels of its layout");
  }
  for (std::size_t i = 0; i < taxels; ++i) {
    if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
        names.begin() + static_cast<std::ptrdiff_t>(i))
      throw DriverError(who + "names " + names[i] + " twice: give each taxel its own column");
  }
  return names;
}

bool Calibration::apply(FrameSlot& frame) const noexcept {
  bool finite = true;
  const auto axis = [&](std::span<float> values, std::size_t which) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = (values[i] - bias[3 * i + which]) * scale[which];
      finite &= std::isfinite(values[i]);
    }
  };
  axis(frame.shear_x_pa, 0);
  axis(frame.shear_y_pa, 1);
  axis(frame.normal_pa, 2);
  return finite;
}

}  // namespace slipd::replay
