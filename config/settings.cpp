#include "config/settings.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "config/convert.hpp"
#include "core/storage/regular_file.hpp"
#include "embedded/slipd_config_schema.hpp"
#include "schema/json_text.hpp"
#include "schema/schema.hpp"

namespace slipd {
namespace {

using nlohmann::json;

const std::string* string_at(const json& object, const char* key) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_string()) return nullptr;
  return &object[key].get_ref<const std::string&>();
}

// Looks up each sensor's driver and checks the sensor's options and device by the driver's schema.
void check_drivers(json& root, DriverCatalogue& drivers, std::vector<Problem>& problems) {
  if (!root.contains("sensors") || !root["sensors"].is_array()) return;
  if (has_problem_exactly_at(problems, "/sensors"))
    return;  // too many of them, say: looking at all takes long
  for (std::size_t i = 0; i < root["sensors"].size(); ++i) {
    json& sensor = root["sensors"][i];
    const std::string at = pointer_to("/sensors", i);
    const std::string* name = string_at(sensor, "driver");
    if (name == nullptr || has_problem_at(problems, at + "/driver")) continue;
    const DriverModule* module = drivers.find(*name);
    if (module == nullptr) {
      // A module that exists but cannot be used is not a misspelt name.
      const auto names = drivers.names();
      const bool there = std::find(names.begin(), names.end(), *name) != names.end();
      problems.push_back(problem_of(
          at + "/driver", *name,
          (there ? "is there, but cannot be used: " : "no such driver" + did_you_mean(*name, names) + "; ") +
              drivers.why_not(*name)));
      continue;
    }
    const auto check_member = [&](const json& schema, const char* member) {
      if (!sensor[member].is_object()) return;
      for (auto& problem : check(schema, sensor[member], pointer_to(at, member)))
        problems.push_back(std::move(problem));
    };
    try {
      const json schema = parse_json_text(module->options_schema);
      check_member(schema, "options");
      const json::json_pointer device("/$defs/device");
      if (schema.contains(device)) check_member(schema[device], "device");
      // SchemaError, JsonTextError: the module is wrong, not the configuration
    } catch (const std::runtime_error& e) {
      problems.push_back(problem_of(at + "/driver", *name,
                                    std::string("the driver describes its options wrongly: ") + e.what()));
    }
  }
}

}  // namespace

Scene Settings::scene_of(const SensorSettings& sensor, const std::optional<SkinInfo>& of_device) const {
  const SensorSetup& setup = sensor.setup;
  const SkinInfo configured{setup.skin_radius_m, setup.skin_modulus_pa, setup.skin_poisson,
                            setup.skin_depth_m, setup.skin_base};
  const SkinKeys& written = sensor.skin_keys;
  const SkinInfo& other = of_device ? *of_device : configured;
  return {{.radius_m = written.radius ? configured.radius_m : other.radius_m,
           .modulus_pa = written.modulus ? configured.modulus_pa : other.modulus_pa,
           .poisson = written.poisson ? configured.poisson : other.poisson,
           .depth_m = written.depth ? configured.depth_m : other.depth_m,
           .depth_sigma = sensor.skin_depth_sigma,
           .base = written.base ? configured.base : other.base},
          objects,
          offset_m,
          noise};
}

Settings parse_settings(const std::string& text, const std::string& name, DriverCatalogue& drivers) {
  json root;
  try {
    root = parse_json_text(text);
  } catch (const JsonTextError& e) {
    throw SettingsError({e.located_in(name)});
  }
  static const json kSchema = parse_json_text(slipd_config_schema);
  const json written = root;
  std::vector<Problem> problems = check(kSchema, root);
  Settings settings;
  const bool all_seen = problems.size() < kMostProblems;
  if (root.is_object() && all_seen) {
    check_drivers(root, drivers, problems);
    settings = convert(root, written, problems);
  }
  if (problems.empty()) return settings;
  std::vector<std::string> lines;
  lines.reserve(problems.size());
  for (const auto& problem : problems) lines.push_back(problem.in(name));
  if (!all_seen) lines.push_back(name + ": and more; mend these first");
  throw SettingsError(std::move(lines));
}

Settings load_settings(const std::filesystem::path& file, DriverCatalogue& drivers) {
  constexpr std::size_t kLargest = 16U << 20U;
  std::string text;
  try {
    text = read_regular_file(file, kLargest);
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::file_too_large)
      throw SettingsError({file.string() + ": is larger than 16 MB, which no configuration is"});
    if (error.code() == std::errc::not_supported) throw SettingsError({std::string(error.what())});
    throw SettingsError({file.string() + ": cannot be read: " + error.code().message()});
  }
  return parse_settings(text, file.string(), drivers);
}

}  // namespace slipd
