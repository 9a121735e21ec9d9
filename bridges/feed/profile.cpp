#include "bridges/feed/profile.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "bridges/support/data_folder.hpp"
#include "bridges/support/settings_file.hpp"
#include "embedded/slipd_feed_message_schema.hpp"

namespace slipd::feed {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::string_view kDevice = "{device}";

HeaderCount count_of(const json& in) {
  return {in["offset"], wire::number_type(in["type"].get<std::string>())};
}

std::string with_device(std::string pointer, const std::string& device) {
  for (std::size_t at = pointer.find(kDevice); at != std::string::npos; at = pointer.find(kDevice))
    pointer.replace(at, kDevice.size(), device);
  return pointer;
}

Place place_of(const json& in, const std::string& device) {
  Place place;
  place.at = with_device(in.value("at", ""), device);
  place.base = in["base"];
  if (in.contains("offset")) place.offset = in["offset"].get<std::size_t>();
  place.name = in.value("name", "");
  if (in.contains("type")) place.type = wire::number_type(in["type"].get<std::string>());
  place.behind = in["behind"];
  return place;
}

// What the schema cannot say of a place.
void check_place(const json& in, const std::string& pointer, Format format, std::vector<Problem>& problems) {
  const auto add = [&](const char* what) { problems.push_back(problem_of(pointer, in, what)); };
  if (in.contains("at") + in.contains("offset") + in.contains("name") != 1)
    return add("expected exactly one of at, offset and name");
  if (in.contains("at") == in.contains("type"))
    return add("numbers at an offset or name need a type; those at a pointer have none");
  if (in.contains("at") && format == Format::bytes) add("bytes have no pointers: expected offset and type");
  if (in.contains("offset") && format == Format::json) add("a JSON text has no offsets: expected at");
  if (in.contains("name") && format != Format::yaml_head) add("only a yaml_head has names");
}

Format format_of(const json& in) {
  const std::string name = in["format"];
  return name == "json" ? Format::json : name == "bytes" ? Format::bytes : Format::yaml_head;
}

int unit_of(const std::string& name) {
  return name == "Pa"       ? SLIPD_UNIT_PA
         : name == "N"      ? SLIPD_UNIT_N
         : name == "counts" ? SLIPD_UNIT_COUNTS
                            : SLIPD_UNIT_UT;
}

std::vector<Problem> further(const json& in) {
  std::vector<Problem> problems;
  const Format format = format_of(in);
  for (const char* key : {"values", "sequence", "time"})
    if (in.contains(key)) check_place(in[key], std::string("/") + key, format, problems);
  if (in.contains("ready")) check_place(in["ready"]["of"], "/ready/of", format, problems);
  if (format == Format::yaml_head && !(in.contains("head") && in.contains("datagrams")))
    problems.push_back(problem_of("/format", in["format"], "needs datagrams and head"));
  if (in.contains("device") && format == Format::bytes)
    problems.push_back(problem_of("/device", in["device"], "bytes have no pointers: leave it out"));
  if (!in.contains("datagrams")) return problems;
  for (const char* key : {"message", "part", "last"}) {
    const HeaderCount count = count_of(in["datagrams"][key]);
    if (count.offset + count.type.bytes > in["datagrams"]["header"].get<std::size_t>())
      problems.push_back(
          problem_of(std::string("/datagrams/") + key, in["datagrams"][key], "is not within the header"));
  }
  return problems;
}

std::vector<fs::path> folders() {
  return {"/etc/slipd/feeds", bridges::data_folder("feeds", SLIPD_INSTALLED_PROFILES)};
}

Profile converted(const json& in, const Instance& instance) {
  const std::string device =
      instance.device.empty() ? in["usual_device"].get<std::string>() : instance.device;
  Profile profile;
  profile.from = in["from"];
  if (in.contains("datagrams")) {
    const json& datagrams = in["datagrams"];
    profile.datagrams = {datagrams["header"], count_of(datagrams["message"]), count_of(datagrams["part"]),
                         count_of(datagrams["last"])};
  }
  profile.format = format_of(in);
  if (in.contains("head"))
    profile.head = {in["head"]["list"], in["head"]["name"], in["head"]["offset"], in["head"]["length"]};
  if (!device.empty()) profile.device = in.value("device", "");
  profile.device_name = device;
  profile.values = place_of(in["values"], device);
  if (in.contains("sequence")) profile.sequence = place_of(in["sequence"], device);
  if (in.contains("time")) profile.time = place_of(in["time"], device);
  profile.time_unit_s = in["time_unit_s"];
  if (in.contains("ready")) profile.ready = {place_of(in["ready"]["of"], device), in["ready"]["is"]};
  profile.frames.taxels =
      static_cast<std::uint32_t>(instance.taxels != 0 ? instance.taxels : in.value("taxels", std::size_t{0}));
  profile.frames.axes = in["axes"];
  profile.frames.unit = unit_of(in["unit"]);
  profile.frames.zero = in["zeroed"].get<bool>() ? SLIPD_ZERO_ZERO : SLIPD_ZERO_MEASURED;
  return profile;
}

Profile checked(const json& in, const std::string& name, const Instance& instance) {
  Profile profile = converted(in, instance);
  if (profile.frames.taxels == 0)
    throw SettingsError({name + ": says no number of taxels: add \"taxels\" to the feed in the settings"});
  return profile;
}

}  // namespace

Profile parse_profile(const std::string& text, const std::string& name, const Instance& instance) {
  return checked(bridges::parse_settings(text, name, slipd_feed_message_schema, further), name, instance);
}

Profile find_profile(const std::string& name, const Instance& instance) {
  const fs::path file = bridges::profile_file(name, folders());
  return checked(bridges::load_settings(file, slipd_feed_message_schema, further), file.string(), instance);
}

}  // namespace slipd::feed
