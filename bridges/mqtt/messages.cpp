#include "bridges/mqtt/messages.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

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

// slipd's object, with the state of now.
Json judged(const slipd_estimate& estimate, std::string_view text) {
  Json object = object_of(text);
  object["sensor"] = estimate.name;
  object["state"] = slipd_state_name(estimate.state);
  if (!std::isnan(slipd_margin(&estimate))) return object;
  object["gamma"] = nullptr;
  object["class"] = nullptr;
  if (estimate.state == SLIPD_STATE_STALE || estimate.state == SLIPD_STATE_DISCONNECTED) {
    for (const char* key : {"gamma_low", "grip_increase_n", "time_to_slip_ms"}) object[key] = nullptr;
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

// The members of slipd's object that an alert has.
constexpr std::array<const char*, 17> kAlertKeys{
    "sensor",          "seq",       "time_ns",  "alert",   "alert_cause", "state",    "gamma",
    "sigma",           "gamma_low", "normal_n", "shear_n", "torque_nmm",  "friction", "time_to_slip_ms",
    "grip_increase_n", "sliding",   "simulated"};

}  // namespace

std::string estimate_message(const slipd_estimate& estimate, std::string_view text) {
  return text_of(judged(estimate, text));
}

std::string state_message(const slipd_estimate& estimate, std::string_view text) {
  const Json all = judged(estimate, text);
  Json object;
  for (const char* key : {"sensor", "time_ns", "state", "health", "alert", "sliding", "simulated"})
    object[key] = all.contains(key) ? all[key] : Json(nullptr);
  return text_of(object);
}

std::string away_message(const std::string& sensor, std::int64_t now_ns) {
  return text_of({{"sensor", sensor},
                  {"time_ns", now_ns},
                  {"state", slipd_state_name(SLIPD_STATE_DISCONNECTED)},
                  {"health", nullptr},
                  {"alert", "none"},
                  {"sliding", nullptr},
                  {"simulated", nullptr}});
}

std::string alert_message(std::string_view text, const std::string& series, std::int64_t number,
                          std::int64_t dropped) {
  const Json all = object_of(text);
  Json object{{"series", series}, {"number", number}, {"dropped", dropped}};
  for (const char* key : kAlertKeys) object[key] = all.contains(key) ? all[key] : Json(nullptr);
  return text_of(object);
}

std::string online_message(const Gripper& gripper, std::int64_t now_ns) {
  Json object{{"status", "online"}, {"time_ns", now_ns}, {"version", gripper.version}};
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

std::string summary_message(const Gripper& gripper, const std::map<std::string, SensorLine>& sensors,
                            std::int64_t alerts_last_hour, std::int64_t now_ns) {
  Json lines = Json::array();
  for (const auto& [name, line] : sensors) {
    lines.push_back({{"sensor", name},
                     {"state", line.state},
                     {"alert", line.alert},
                     {"gamma", std::isnan(line.gamma) ? Json(nullptr) : Json(line.gamma)}});
  }
  return text_of({{"time_ns", now_ns},
                  {"version", gripper.slipd ? Json(gripper.slipd->version) : Json(nullptr)},
                  {"sensors", std::move(lines)},
                  {"alerts_last_hour", alerts_last_hour},
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
