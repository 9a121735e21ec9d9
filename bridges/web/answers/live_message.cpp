#include "bridges/web/answers/live_message.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

namespace slipd::web {
namespace {

using Json = nlohmann::json;

// What an estimate keeps when its frame is too old.
constexpr std::string_view kLasting[] = {"sensor", "grasp",       "sensors", "seq",   "time_ns",  "age_ms",
                                         "alert",  "alert_cause", "method",  "state", "simulated"};

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<double> age_of(const Json& estimate) {
  const auto age = estimate.find("age_ms");
  if (age == estimate.end() || !age->is_number()) return std::nullopt;
  return age->get<double>();
}

// Absent: one of them has none.
std::optional<double> oldest_of(const Json& members, const Json& sensors) {
  double oldest = 0;
  for (const Json& name : members) {
    const auto at = std::find_if(sensors.begin(), sensors.end(),
                                 [&](const Json& each) { return each.at("sensor") == name; });
    const auto age = at == sensors.end() ? std::nullopt : age_of(*at);
    if (!age) return std::nullopt;
    oldest = std::max(oldest, *age);
  }
  return members.empty() ? std::nullopt : std::optional(oldest);
}

// Without frames an alert that was raised stands, and that there is none is not known any more.
void without_frames(Json& estimate, std::string_view state) {
  for (auto& [key, value] : estimate.items()) {
    if (std::find(std::begin(kLasting), std::end(kLasting), key) == std::end(kLasting)) value = nullptr;
  }
  estimate["state"] = state;
  if (estimate.at("alert") == "none") estimate["alert"] = "unknown";
  if (estimate.contains("health")) estimate["health"] = "unknown";
}

void judge(Json& estimate, std::optional<double> age_ms, double max_age_ms) {
  const bool young = age_ms && *age_ms <= max_age_ms;
  if (!young) without_frames(estimate, estimate.at("state") == "fault" ? "fault" : "stale");
  if (estimate.at("state") != "ok") estimate["gamma"] = nullptr;
}

// Those of a message of before, as they are while slipd is away.
Json disconnected(const Json& live, const char* kind) {
  Json estimates = live.is_object() ? live.at(kind) : Json::array();
  for (Json& estimate : estimates) {
    without_frames(estimate, "disconnected");
    estimate["age_ms"] = nullptr;
  }
  return estimates;
}

}  // namespace

std::string live_message(const Answer& gamma, double max_age_ms) {
  Json answer = Json::parse(gamma.text);
  Json& sensors = answer.at("sensors");
  Json& grasps = answer.at("grasps");
  for (Json& sensor : sensors) {
    if (const auto age = age_of(sensor)) sensor["age_ms"] = *age + gamma.waited_ms();
  }
  for (Json& grasp : grasps) {
    const auto age = oldest_of(grasp.at("sensors"), sensors);
    grasp["age_ms"] = age ? Json(*age) : Json(nullptr);
    // Its sensors say whether they are simulated.
    grasp["simulated"] = std::any_of(sensors.begin(), sensors.end(), [&](const Json& each) {
      const Json& members = grasp.at("sensors");
      return each.value("simulated", false) &&
             std::find(members.begin(), members.end(), each.at("sensor")) != members.end();
    });
    judge(grasp, age, max_age_ms);
  }
  for (Json& sensor : sensors) judge(sensor, age_of(sensor), max_age_ms);
  return text_of({{"type", "live"},
                  {"slipd", "ok"},
                  {"made_ms", gamma.had_ms},
                  {"sensors", std::move(sensors)},
                  {"grasps", std::move(grasps)}});
}

std::string away_message(std::string_view why, std::string_view last_live) {
  const Json last = Json::parse(last_live, nullptr, false);
  return text_of({{"type", "live"},
                  {"slipd", "away"},
                  {"why", why},
                  {"sensors", disconnected(last, "sensors")},
                  {"grasps", disconnected(last, "grasps")}});
}

std::string status_message(std::string_view sensors_answer, std::string_view status_answer) {
  return text_of({{"type", "status"},
                  {"sensors", Json::parse(sensors_answer).at("sensors")},
                  {"status", Json::parse(status_answer)}});
}

std::string hello_message(std::string_view version, double max_age_ms) {
  return text_of({{"type", "hello"}, {"protocol", 1}, {"version", version}, {"max_age_ms", max_age_ms}});
}

}  // namespace slipd::web
