#include "drivers/decode/profile.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "core/storage/regular_file.hpp"
#include "drivers/decode/profile_parts.hpp"
#include "embedded/profile_schema.hpp"
#include "schema/json_text.hpp"
#include "schema/schema.hpp"

namespace slipd::decode {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t kLargestProfile = std::size_t{16} << 20;  // bytes

[[noreturn]] void refuse(const std::string& name, const std::vector<Problem>& problems) {
  std::string lines = "profile \"" + name + "\" cannot work:";
  for (const Problem& problem : problems) lines += "\n  " + problem.in(name + ".json");
  throw DriverError(lines);
}

std::vector<fs::path> folders() {
  std::vector<fs::path> found{"/etc/slipd/profiles"};
  Dl_info here{};
  // dladdr knows only the bare name of a program that was found by PATH.
  fs::path code;
  if (dladdr(reinterpret_cast<const void*>(&parse_profile), &here) != 0 && here.dli_fname != nullptr)
    code = here.dli_fname;
  std::error_code unknown;
  if (!code.has_parent_path()) code = fs::read_symlink("/proc/self/exe", unknown);
  if (!code.empty()) found.push_back(fs::absolute(code).parent_path().parent_path() / "profiles");
  found.emplace_back(SLIPD_INSTALLED_PROFILES);
  return found;
}

}  // namespace

Profile parse_profile(const std::string& text, const std::string& name) {
  static const json kSchema = parse_json_text(profile_schema);
  json in;
  try {
    in = parse_json_text(text);
  } catch (const JsonTextError& error) {
    throw DriverError("profile " + error.located_in(name + ".json"));
  }
  std::vector<Problem> problems = check(kSchema, in);
  if (!problems.empty()) refuse(name, problems);
  Profile profile = converted(in, problems);
  if (problems.empty()) find_contradictions(in, profile, problems);
  if (!problems.empty()) refuse(name, problems);
  return profile;
}

Profile find_profile(const std::string& name) {
  std::string looked;
  for (const fs::path& folder : folders()) {
    const fs::path path = folder / (name + ".json");
    std::string text;
    try {
      text = read_regular_file(path, kLargestProfile);
    } catch (const std::system_error& error) {
      if (error.code() != std::errc::no_such_file_or_directory)
        throw DriverError(std::string("profile ") + error.what());
      looked += (looked.empty() ? "" : ", ") + path.string();
      continue;
    }
    return parse_profile(text, name);
  }
  throw DriverError("there is no profile \"" + name + "\"; looked for " + looked);
}

SensorInfo info_of(const Profile& profile, std::string part) {
  double step_normal_pa = 0, step_shear_pa = 0;
  for (const PacketRule& rule : profile.scan) {
    for (const Field& field : rule.fields) {
      double& step_pa = field.channel == Channel::normal ? step_normal_pa : step_shear_pa;
      if (field.type.kind != NumberKind::real) step_pa = std::max(step_pa, std::abs(field.gain_pa));
    }
  }
  return {.sensor_class = profile.sensor_class,
          .layout = profile.layout,
          .rate_hz = profile.rate_hz,
          .skin = profile.skin,
          .zeroed = profile.zeroed,
          .calibrated = profile.calibrated,
          .part = std::move(part),
          .step_normal_pa = step_normal_pa,
          .step_shear_pa = step_shear_pa};
}

std::vector<std::string> profile_names() {
  std::set<std::string> names;
  for (const fs::path& folder : folders()) {
    std::error_code absent;
    for (const auto& file : fs::directory_iterator(folder, absent))
      if (file.path().extension() == ".json") names.insert(file.path().stem());
  }
  return {names.begin(), names.end()};
}

Profile profile_of(const std::vector<SensorSetup>& sensors, const std::string& driver) {
  const std::string& name = sensors.front().profile;
  for (const SensorSetup& sensor : sensors) {
    if (sensor.profile.empty()) {
      throw DriverError("sensor \"" + sensor.name + "\": driver " + driver +
                        " needs a \"profile\", which says what the device sends");
    }
    if (sensor.profile != name) {
      throw DriverError("sensor \"" + sensor.name + "\": profile \"" + sensor.profile +
                        "\", but it shares its device with a sensor of profile \"" + name +
                        "\"; give all of one device the same");
    }
  }
  Profile profile = find_profile(name);
  if (profile.driver != driver) {
    throw DriverError("profile \"" + name + "\" is for driver " + profile.driver + ", not " + driver +
                      ": change the sensor's \"driver\"");
  }
  return profile;
}

}  // namespace slipd::decode
