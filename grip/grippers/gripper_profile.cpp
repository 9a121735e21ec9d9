#include "grip/grippers/gripper_profile.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "bridges/support/data_folder.hpp"
#include "bridges/support/settings_file.hpp"
#include "embedded/slipd_gripper_profile_schema.hpp"

namespace slipd::grip {
namespace {

using json = nlohmann::json;

// A part of a register, as a count.
struct Field {
  std::size_t index;
  int shift;
  int bits;

  explicit Field(const json& part)
      : index(part.at("index")), shift(part.at("shift")), bits(part.at("bits")) {}
  unsigned mask() const { return (1U << bits) - 1U; }
  unsigned of(std::span<const std::uint16_t> registers) const {
    return index < registers.size() ? (registers[index] >> shift) & mask() : 0;
  }
};

// Linear from a range of a quantity to a range of counts. Beyond its ends the end counts.
double count_of(double value, const json& range, const json& counts) {
  const double low = range.at(0), high = range.at(1), first = counts.at(0), last = counts.at(1);
  return first + std::clamp((value - low) / (high - low), 0.0, 1.0) * (last - first);
}

bool matches(const json& part, std::span<const std::uint16_t> registers) {
  return Field(part).of(registers) == part.at("equals").get<unsigned>();
}

}  // namespace

GripperProfile::GripperProfile(const json& checked) : json_(checked) {}

std::uint16_t GripperProfile::force_count(double force_n, double most_n) const {
  constexpr double kSameCount = 1e-6;
  const json& force = json_.at("force");
  const auto count = [&](double n) { return count_of(n, force.at("range_n"), force.at("counts")); };
  const double up = std::ceil(count(force_n) - kSameCount), highest = std::floor(count(most_n) + kSameCount);
  return static_cast<std::uint16_t>(std::min(up, highest));
}

RegisterWrite GripperProfile::write(const Command& command, double most_n) const {
  const json& write = json_.at("write");
  RegisterWrite made{.first = write.at("first"), .values = std::vector<std::uint16_t>(write.at("count"), 0)};
  const bool opens = command.order.move == Move::open;
  for (const json& part : write.at("fields")) {
    const Field field(part);
    const std::string what = part.at("is");
    unsigned count = 0;
    if (what == "constant") count = part.at("count").get<unsigned>();
    if (what == "target") count = json_.at("target").at(opens ? "open" : "closed").get<unsigned>();
    if (what == "force") count = force_count(opens ? least_n() : command.order.force_n, most_n);
    if (what == "speed")
      count = static_cast<unsigned>(std::floor(
          count_of(command.speed_mm_s, json_.at("speed").at("range_mm_s"), json_.at("speed").at("counts"))));
    made.values.at(field.index) |= static_cast<std::uint16_t>((count & field.mask()) << field.shift);
  }
  return made;
}

std::vector<RegisterWrite> GripperProfile::activation() const {
  std::vector<RegisterWrite> writes;
  for (const json& one : json_.at("activation"))
    writes.push_back(
        {.first = json_.at("write").at("first"), .values = one.get<std::vector<std::uint16_t>>()});
  return writes;
}

GripperProfile::Status GripperProfile::status(std::span<const std::uint16_t> registers) const {
  const json& read = json_.at("read");
  Status status;
  if (read.contains("ready")) status.ready = matches(read.at("ready"), registers);
  if (read.contains("busy")) status.busy = matches(read.at("busy"), registers);
  if (read.contains("fault")) status.fault = Field(read.at("fault")).of(registers) != 0;
  if (read.contains("width")) {
    const json& width = read.at("width");
    const double count = Field(width).of(registers);
    const json &counts = width.at("counts"), &range = width.at("range_mm");
    const double first = counts.at(0), last = counts.at(1), low = range.at(0), high = range.at(1);
    status.facts.width_mm = low + (count - first) / (last - first) * (high - low);
  }
  return status;
}

std::optional<double> GripperProfile::least_speed_mm_s() const {
  if (!json_.contains("speed")) return std::nullopt;
  return json_.at("speed").at("range_mm_s").at(0).get<double>();
}

std::vector<Problem> problems_of_profile(const json& checked) {
  std::vector<Problem> problems;
  const auto add = [&](const std::string& where, const std::string& what) {
    problems.push_back(problem_at(where, checked, what));
  };
  const json &write = checked.at("write"), &read = checked.at("read");
  const auto check_index = [&](const std::string& where, const json& registers) {
    if (checked.at(json::json_pointer(where)).at("index") >= registers.at("count"))
      add(where + "/index", "is behind the last register: \"count\" is " + registers.at("count").dump());
  };
  for (std::size_t i = 0; i < write.at("fields").size(); ++i) {
    const std::string where = "/write/fields/" + std::to_string(i);
    const json& field = write.at("fields").at(i);
    check_index(where, write);
    if (field.at("is") == "constant" && !field.contains("count")) add(where, "a constant needs \"count\"");
    if (field.at("is") == "speed" && !checked.contains("speed"))
      add(where + "/is", "needs the gripper's \"speed\", which this profile does not state");
  }
  for (const char* const key : {"ready", "busy", "fault", "width"})
    if (read.contains(key)) check_index(std::string("/read/") + key, read);
  for (const char* const where : {"/force/range_n", "/speed/range_mm_s", "/read/width/counts"}) {
    const json::json_pointer at(where);
    if (checked.contains(at) && checked.at(at).at(0) == checked.at(at).at(1)) add(where, "is no range");
  }
  return problems;
}

GripperProfile load_profile(const std::string& name_or_path) {
  const bool is_path = name_or_path.find('/') != std::string::npos;
  const std::filesystem::path file =
      is_path ? std::filesystem::path(name_or_path)
              : bridges::data_folder("grippers", SLIPD_INSTALLED_PROFILES) / (name_or_path + ".json");
  try {
    return GripperProfile(bridges::load_settings(file, slipd_gripper_profile_schema, problems_of_profile));
  } catch (const SettingsError& error) {
    throw GripperError(error.what());
  }
}

}  // namespace slipd::grip
