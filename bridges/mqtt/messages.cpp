#include "bridges/mqtt/messages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "clients/c/alert.hpp"

namespace slipd::mqtt {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& object) {
  return object.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json object_of(std::string_view text) {
  Json object = Json::parse(text, nullptr, false);
  return object.is_object() ? object : Json::object();
}

// slipd's object, with the state and alert of now.
Json judged(const slipd_estimate& estimate, std::string_view text) {
  Json object = object_of(text);
  object[object.contains("grasp") ? "grasp" : "sensor"] = estimate.name;
  object["state"] = slipd_state_name(estimate.state);
  object["alert"] = slipd_alert_name(estimate.alert);
  if (estimate.sliding == SLIPD_SLIDING_UNKNOWN) object["sliding"] = object["sliding_for_ms"] = nullptr;
  if (estimate.state == SLIPD_STATE_STALE && object.contains("health")) object["health"] = "unknown";
  if (!std::isnan(slipd_margin(&estimate))) return object;
  object["gamma"] = nullptr;
  object["class"] = nullptr;
  if (estimate.state == SLIPD_STATE_STALE || estimate.state == SLIPD_STATE_DISCONNECTED) {
    for (const char* key : {"gamma_low", "grip_increase_n", "time_to_slip_ms"}) object[key] = nullptr;
    if (object.contains("first")) object["first"] = nullptr;
  }
  return object;
}

Json inventory_json(const bridges::Inventory& inventory) {
  Json sensors = Json::array(), grasps = Json::array();
  for (const auto& each : inventory.sensors) {
    sensors.push_back({{"name", each.name},
                       {"class", each.kind},
                       {"taxels", each.taxels},
                       {"rate_hz", each.rate_hz},
                       {"driver", each.driver},
                       {"simulated", each.simulated}});
  }
  for (const auto& each : inventory.grasps)
    grasps.push_back({{"name", each.name}, {"sensors", each.sensors}});
  return {{"sensors", std::move(sensors)}, {"grasps", std::move(grasps)}};
}

Json counts_json(const AlertCounts& alerts) {
  return {{"series", alerts.series},
          {"last", alerts.last},
          {"waiting", alerts.waiting},
          {"dropped", alerts.dropped}};
}

// The members of slipd's object that messages have.
using Keys = std::vector<const char*>;
const Keys kAlertKeys{"sensor",  "seq",        "time_ns",  "alert",           "alert_cause",
                      "state",   "gamma",      "sigma",    "gamma_low",       "normal_n",
                      "shear_n", "torque_nmm", "friction", "time_to_slip_ms", "grip_increase_n",
                      "sliding", "simulated"};
const Keys kGraspAlertKeys{"grasp",       "sensors",  "first",    "time_ns",         "alert",
                           "alert_cause", "state",    "gamma",    "sigma",           "gamma_low",
                           "normal_n",    "shear_n",  "friction", "time_to_slip_ms", "grip_increase_n",
                           "sliding",     "simulated"};
const Keys kStateKeys{"sensor", "time_ns", "state", "health", "alert", "sliding", "simulated"};
const Keys kGraspStateKeys{"grasp", "sensors", "time_ns", "state", "alert", "sliding", "simulated"};

// Those members of `all`; null where it has none.
void copy_members(const Json& all, const Keys& keys, Json& out) {
  for (const char* key : keys) out[key] = all.contains(key) ? all[key] : Json(nullptr);
}

// The code of a state's or alert's name; `otherwise` for a name that there is not.
template <typename Name>
std::int32_t code_of(const Json& object, const char* key, int last, Name name_of, int otherwise) {
  const auto at = object.find(key);
  if (at == object.end() || !at->is_string()) return otherwise;
  for (int code = 0; code <= last; ++code)
    if (*at == name_of(code)) return code;
  return otherwise;
}

// Adds to a grasp what its sensors say: time and age of the oldest, and whether one is simulated.
void add_facts(Json& grasp, const Json& sensors) {
  Json oldest_age, oldest_time;
  bool simulated = false;
  std::size_t with_frame = 0;
  const Json names = grasp.contains("sensors") ? grasp["sensors"] : Json::array();
  for (const Json& sensor : sensors) {
    if (!sensor.is_object() || !sensor.contains("sensor") ||
        std::find(names.begin(), names.end(), sensor["sensor"]) == names.end())
      continue;
    simulated = simulated || sensor.value("simulated", Json(false)) == true;
    const Json age = sensor.value("age_ms", Json()), time = sensor.value("time_ns", Json());
    if (!age.is_number() || !time.is_number_integer()) continue;
    ++with_frame;
    if (oldest_age.is_number() && age.get<double>() < oldest_age.get<double>()) continue;
    oldest_age = age;
    oldest_time = time;
  }
  const bool known = with_frame > 0 && with_frame == names.size();
  grasp["time_ns"] = known ? oldest_time : Json(nullptr);
  grasp["age_ms"] = known ? oldest_age : Json(nullptr);
  grasp["simulated"] = simulated;
}

// Empty: it has no name that fits.
std::optional<GraspEstimate> grasp_of(Json grasp, const Json& sensors, double max_age_s,
                                      std::int64_t monotonic_ns) {
  constexpr double kMsPerS = 1e3, kNsPerS = 1e9;
  GraspEstimate out;
  if (!grasp.is_object() || !grasp.contains("grasp") || !grasp["grasp"].is_string()) return std::nullopt;
  const std::string name = grasp["grasp"];
  if (name.empty() || name.size() >= sizeof(out.estimate.name)) return std::nullopt;
  add_facts(grasp, sensors);
  slipd_estimate& estimate = out.estimate;
  name.copy(estimate.name, name.size());
  estimate.state = code_of(grasp, "state", SLIPD_STATE_DISCONNECTED, slipd_state_name, SLIPD_STATE_FAULT);
  estimate.alert = code_of(grasp, "alert", SLIPD_ALERT_UNKNOWN, slipd_alert_name, SLIPD_ALERT_SLIP);
  estimate.age_s = grasp["age_ms"].is_number() ? grasp["age_ms"].get<double>() / kMsPerS
                                               : std::numeric_limits<double>::infinity();
  const bool young = estimate.age_s <= max_age_s;
  if (!young) grow_old(estimate);
  const bool has_margin =
      estimate.state == SLIPD_STATE_OK && grasp.contains("gamma") && grasp["gamma"].is_number();
  estimate.gamma = has_margin ? grasp["gamma"].get<double>() : std::numeric_limits<double>::quiet_NaN();
  estimate.valid_until_ns =
      young ? monotonic_ns + static_cast<std::int64_t>(kNsPerS * (max_age_s - estimate.age_s)) : monotonic_ns;
  out.text = text_of(grasp);
  return out;
}

Json line_json(const char* key, const std::string& name, const SummaryLine& line) {
  const auto number = [](double value) { return std::isnan(value) ? Json(nullptr) : Json(value); };
  return {{key, name},
          {"state", line.state},
          {"alert", line.alert},
          {"gamma", number(line.gamma)},
          {"gamma_min", number(line.gamma_min)}};
}

}  // namespace

void grow_old(slipd_estimate& estimate) {
  if (estimate.state != SLIPD_STATE_FAULT) estimate.state = SLIPD_STATE_STALE;
  estimate.alert = client::without_frames(estimate.alert);
  estimate.sliding = SLIPD_SLIDING_UNKNOWN;
  estimate.gamma = std::numeric_limits<double>::quiet_NaN();
}

std::vector<GraspEstimate> grasps_of(std::string_view answer, double max_age_s, std::int64_t monotonic_ns) {
  std::vector<GraspEstimate> found;
  const Json all = object_of(answer);
  const Json sensors = all.value("sensors", Json::array());
  for (const Json& each : all.value("grasps", Json::array())) {
    if (auto grasp = grasp_of(each, sensors, max_age_s, monotonic_ns)) found.push_back(std::move(*grasp));
  }
  return found;
}

std::string estimate_message(const slipd_estimate& estimate, std::string_view text) {
  return text_of(judged(estimate, text));
}

std::string state_message(const slipd_estimate& estimate, std::string_view text,
                          std::chrono::milliseconds valid_for) {
  const Json all = judged(estimate, text);
  Json object;
  copy_members(all, all.contains("grasp") ? kGraspStateKeys : kStateKeys, object);
  object["valid_for_ms"] = valid_for.count();
  return text_of(object);
}

std::string away_text(const std::string& sensor, std::int64_t now_ns) {
  return text_of({{"sensor", sensor}, {"time_ns", now_ns}});
}

std::string away_text(const bridges::GraspFacts& grasp, std::int64_t now_ns) {
  return text_of({{"grasp", grasp.name}, {"sensors", grasp.sensors}, {"time_ns", now_ns}});
}

std::string alert_message(std::string_view text, const std::string& series, std::int64_t number,
                          std::int64_t dropped) {
  const Json all = object_of(text);
  Json object{{"series", series}, {"number", number}, {"dropped", dropped}};
  copy_members(all, all.contains("grasp") ? kGraspAlertKeys : kAlertKeys, object);
  return text_of(object);
}

std::string online_message(const Gripper& gripper, std::int64_t now_ns) {
  Json object{{"status", "online"},
              {"time_ns", now_ns},
              {"valid_for_ms", gripper.valid_for.count()},
              {"version", gripper.version}};
  object["slipd"] = gripper.slipd ? Json(gripper.slipd->version) : Json(nullptr);
  if (!gripper.slipd) object["trouble"] = gripper.trouble;
  const Json inventory = inventory_json(gripper.slipd.value_or(bridges::Inventory{}));
  object["sensors"] = inventory["sensors"];
  object["grasps"] = inventory["grasps"];
  object["hash"] = gripper.slipd ? Json(inventory_hash(*gripper.slipd)) : Json(nullptr);
  object["alerts"] = counts_json(gripper.alerts);
  return text_of(object);
}

std::string offline_message(std::int64_t now_ns) {
  return text_of({{"status", "offline"}, {"time_ns", now_ns > 0 ? Json(now_ns) : Json(nullptr)}});
}

std::string seen_message(const Gripper& gripper, std::int64_t now_ns) {
  return text_of(
      {{"time_ns", now_ns}, {"version", gripper.slipd ? Json(gripper.slipd->version) : Json(nullptr)}});
}

std::string summary_message(const Gripper& gripper, const Summary& summary, std::int64_t now_ns) {
  Json sensors = Json::array(), grasps = Json::array();
  for (const auto& [name, line] : summary.sensors) sensors.push_back(line_json("sensor", name, line));
  for (const auto& [name, line] : summary.grasps) grasps.push_back(line_json("grasp", name, line));
  return text_of(
      {{"time_ns", now_ns},
       {"period_s", summary.period_s},
       {"version", gripper.slipd ? Json(gripper.slipd->version) : Json(nullptr)},
       {"sensors", std::move(sensors)},
       {"grasps", std::move(grasps)},
       {"alerts_last_hour", summary.alerts_last_hour ? Json(*summary.alerts_last_hour) : Json(nullptr)},
       {"alerts", counts_json(gripper.alerts)}});
}

std::string inventory_hash(const bridges::Inventory& inventory) {
  // FNV-1a of 64 bits (Fowler, Noll, Vo): equal for equal texts on every machine, which std::hash is not.
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char byte : text_of(inventory_json(inventory)))
    hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3U;
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(hash));
  return digits.data();
}

}  // namespace slipd::mqtt
