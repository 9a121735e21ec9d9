#include "drivers/push/options.hpp"

#include <nlohmann/json.hpp>

#include "drivers/push/push_socket.hpp"

namespace slipd::push {
namespace {

using push_layout::Unit;

constexpr double kNsPerMs = 1e6;

Unit unit_of(const std::string& text) {
  if (text == "Pa") return Unit::pascal;
  if (text == "N") return Unit::newton;
  if (text == "counts") return Unit::counts;
  return text == "uT" ? Unit::microtesla : Unit::millimetre;
}

std::array<float, 3> scale_of(const nlohmann::json& given) {
  if (given.is_array()) return given.get<std::array<float, 3>>();
  const auto factor = given.get<float>();
  return {factor, factor, factor};
}

std::filesystem::path path_of(const SensorSetup& sensor) {
  if (sensor.options.contains("path")) return sensor.options["path"].get<std::string>();
  return std::filesystem::path(sensor.runtime_folder) / "push" / sensor.name;
}

}  // namespace

Options parse_options(const SensorSetup& sensor) {
  const std::string who = "sensor \"" + sensor.name + "\": ";
  const nlohmann::json& given = sensor.options;
  Options options;
  if (given.contains("unit")) options.unit = unit_of(given["unit"]);
  if (given.contains("axes")) options.axes = given["axes"].get<std::uint8_t>();
  if (given.contains("zeroed")) options.zeroed = given["zeroed"].get<bool>();
  if (given.contains("scale")) options.scale = scale_of(given["scale"]);
  options.max_age_ns = static_cast<std::int64_t>(kNsPerMs * given.value("max_age_ms", 100.0));
  options.path = path_of(sensor);
  options.mode = static_cast<unsigned>(std::stoul(given.value("mode", std::string("0660")), nullptr, 8));
  options.owner = given.value("owner", "");
  options.group = given.value("group", "");
  if (options.path.native().size() > kLongestPath) {
    throw DriverError(who + "the socket " + options.path.string() + " has a longer path than the " +
                      std::to_string(kLongestPath) + " bytes that its socket may have: give options.path");
  }
  const std::size_t longest = push_layout::frame_size(sensor.layout.size(), options.axes.value_or(3));
  if (longest > push_layout::kLongestMessage) {
    throw DriverError(who + "a frame of its " + std::to_string(sensor.layout.size()) + " taxels has " +
                      std::to_string(longest) + " bytes, and push takes " +
                      std::to_string(push_layout::kLongestMessage) +
                      ": give it the layout of the program's frames");
  }
  return options;
}

}  // namespace slipd::push
