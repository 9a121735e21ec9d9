#include "bridges/feed_ros2/topic_profile.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "bridges/ros2/messages/messages.hpp"
#include "bridges/support/data_folder.hpp"
#include "bridges/support/settings_file.hpp"
#include "embedded/slipd_feed_topic_schema.hpp"

namespace slipd::feed_ros2 {
namespace {

using nlohmann::json;

constexpr std::size_t kAxes = 3;

TopicType type_of(const json& in) {
  const std::string name = in["type"];
  return name == "sensor_msgs/PointCloud2"       ? TopicType::point_cloud
         : name == "geometry_msgs/WrenchStamped" ? TopicType::wrench
                                                 : TopicType::array;
}

TimeOf time_of(const json& in, TopicType type) {
  if (!in.contains("time")) return type == TopicType::array ? TimeOf::sent : TimeOf::stamp;
  const std::string name = in["time"];
  return name == "stamp" ? TimeOf::stamp : name == "sent" ? TimeOf::sent : TimeOf::received;
}

int unit_of(const std::string& name) {
  return name == "Pa"       ? SLIPD_UNIT_PA
         : name == "N"      ? SLIPD_UNIT_N
         : name == "counts" ? SLIPD_UNIT_COUNTS
                            : SLIPD_UNIT_UT;
}

std::size_t axes_of(const json& in, TopicType type) {
  return type == TopicType::wrench ? kAxes : in[type == TopicType::array ? "columns" : "fields"].size();
}

// What the schema cannot say.
std::vector<Problem> further(const json& in) {
  std::vector<Problem> problems;
  const TopicType type = type_of(in);
  const auto only = [&](const char* key, TopicType of, const char* what) {
    if (in.contains(key) && type != of)
      problems.push_back(
          problem_of(std::string("/") + key, in[key], std::string("is for ") + what + " only"));
    if (!in.contains(key) && type == of)
      problems.push_back(problem_of("/type", in["type"], std::string("needs ") + key));
  };
  only("fields", TopicType::point_cloud, "sensor_msgs/PointCloud2");
  only("columns", TopicType::array, "std_msgs/Float32MultiArray");
  only("array", TopicType::array, "std_msgs/Float32MultiArray");
  if (!problems.empty()) return problems;
  if (axes_of(in, type) == 2)
    problems.push_back(problem_of(type == TopicType::array ? "/columns" : "/fields",
                                  in[type == TopicType::array ? "columns" : "fields"],
                                  "expected three, of x, y and z, or one, of z"));
  if (type == TopicType::wrench && in.value("taxels", 1) != 1)
    problems.push_back(problem_of("/taxels", in["taxels"], "a wrench is one taxel"));
  if (type == TopicType::array) {
    for (const json& column : in["columns"])
      if (column.get<std::size_t>() >= in["array"]["row"].get<std::size_t>())
        problems.push_back(problem_of("/columns", in["columns"], "each is less than array.row"));
    if (in.value("time", "") == "stamp")
      problems.push_back(problem_of("/time", in["time"], "a Float32MultiArray has no stamp: expected sent"));
  }
  return problems;
}

TopicProfile converted(const json& in, const TopicInstance& instance) {
  TopicProfile profile;
  profile.topic = instance.topic.empty() ? in.value("topic", "") : instance.topic;
  profile.type = type_of(in);
  if (profile.type == TopicType::wrench) profile.fields = {"force.x", "force.y", "force.z"};
  if (profile.type == TopicType::point_cloud) profile.fields = in["fields"];
  if (profile.type == TopicType::array) {
    profile.columns = in["columns"].get<std::vector<std::size_t>>();
    const json& array = in["array"];
    profile.array = {array["first"], array["row"], array["order"] == "axes", array["behind"]};
  }
  profile.time = time_of(in, profile.type);
  profile.frame_id = instance.frame_id;
  profile.qos = {in["qos"]["reliable"], in["qos"]["depth"]};
  const std::size_t usual = profile.type == TopicType::wrench ? 1 : in.value("taxels", std::size_t{0});
  profile.frames.taxels = static_cast<std::uint32_t>(instance.taxels != 0 ? instance.taxels : usual);
  profile.frames.axes = static_cast<std::int32_t>(axes_of(in, profile.type));
  profile.frames.unit = unit_of(in["unit"]);
  profile.frames.zero = in["zeroed"].get<bool>() ? SLIPD_ZERO_ZERO : SLIPD_ZERO_MEASURED;
  profile.frames.rate_hz = in["rate_hz"];
  return profile;
}

TopicProfile checked(const json& in, const std::string& name, const TopicInstance& instance) {
  TopicProfile profile = converted(in, instance);
  if (profile.frames.taxels == 0)
    throw SettingsError({name + ": says no number of taxels: add \"taxels\" to the feed in the settings"});
  if (profile.type == TopicType::wrench && profile.frames.taxels != 1)
    throw SettingsError({name + ": a wrench is one taxel: leave \"taxels\" out of the settings"});
  if (profile.type == TopicType::array && !profile.frame_id.empty())
    throw SettingsError({name + ": a Float32MultiArray has no frame_id: leave it out of the settings"});
  return profile;
}

}  // namespace

const char* message_name(TopicType type) noexcept {
  return type == TopicType::point_cloud ? ros2::PointCloud2::kName.data()
         : type == TopicType::wrench    ? ros2::WrenchStamped::kName.data()
                                        : ros2::Float32MultiArray::kName.data();
}

TopicProfile parse_topic_profile(const std::string& text, const std::string& name,
                                 const TopicInstance& instance) {
  return checked(bridges::parse_settings(text, name, slipd_feed_topic_schema, further), name, instance);
}

TopicProfile find_topic_profile(const std::string& name, const TopicInstance& instance) {
  const auto file = bridges::profile_file(
      name, {"/etc/slipd/topics", bridges::data_folder("topics", SLIPD_INSTALLED_PROFILES)});
  return checked(bridges::load_settings(file, slipd_feed_topic_schema, further), file.string(), instance);
}

}  // namespace slipd::feed_ros2
