#include "bridges/web/live_message.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

namespace slipd::web {
namespace {

using Json = nlohmann::json;

constexpr const char* kMarginKeys[] = {
    "gamma",           "sigma",           "gamma_low", "class",
    "time_to_slip_ms", "grip_increase_n", "sliding",   "grip_increase_sigma_n",
    "sliding_for_ms",  "a_over_r",        "first"};

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

void judge(Json& estimate, std::optional<double> age_ms, double max_age_ms) {
  const bool young = age_ms && *age_ms <= max_age_ms;
  if (!young && estimate.at("state") != "fault") estimate["state"] = "stale";
  if (estimate.at("state") != "ok") estimate["gamma"] = nullptr;
  if (young) return;
  for (const char* key : kMarginKeys) {
    if (estimate.contains(key)) estimate[key] = nullptr;
  }
}

}  // namespace

std::string live_message(std::string_view gamma_answer, double max_age_ms) {
  Json answer = Json::parse(gamma_answer);
  Json& sensors = answer.at("sensors");
  Json& grasps = answer.at("grasps");
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
  return text_of(
      {{"type", "live"}, {"slipd", "ok"}, {"sensors", std::move(sensors)}, {"grasps", std::move(grasps)}});
}

std::string away_message(std::string_view why) {
  return text_of({{"type", "live"},
                  {"slipd", "away"},
                  {"why", why},
                  {"sensors", Json::array()},
                  {"grasps", Json::array()}});
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
