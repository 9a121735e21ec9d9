#include "bridges/web/answers/live_message.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace slipd::web {
namespace {

using Json = nlohmann::json;

constexpr double kMaxAgeMs = 100;

Json sensor(const char* name, const Json& age_ms, const char* state = "ok") {
  return {
      {"sensor", name},          {"state", state},   {"gamma", 0.5},           {"sigma", 0.01},
      {"gamma_low", 0.4},        {"class", 3},       {"grip_increase_n", 0.1}, {"alert", "warn"},
      {"alert_cause", "margin"}, {"age_ms", age_ms}, {"simulated", true},      {"sliding", "none"},
      {"health", "good"},        {"normal_n", 2.1},  {"center_mm", {0, 0}},    {"truth", {{"gamma", 0.5}}}};
}

Json message_of(const Json& sensors, const Json& grasps = Json::array(), double waited_ms = 0) {
  const Answer answer{Json{{"sensors", sensors}, {"grasps", grasps}}.dump(), 1000, 1000 + waited_ms};
  return Json::parse(live_message(answer, kMaxAgeMs));
}

TEST(LiveMessage, AnAnswerIsAsOldAsItMayBe) {
  const Json grasp{{"grasp", "g"}, {"sensors", {"left"}}, {"state", "ok"}, {"gamma", 0.3}, {"alert", "none"}};
  Json message = message_of(Json::array({sensor("left", 5)}), Json::array({grasp}), 50);
  EXPECT_EQ(message.at("made_ms"), 1050);
  EXPECT_EQ(message.at("sensors").at(0).at("age_ms"), 55);
  EXPECT_EQ(message.at("grasps").at(0).at("age_ms"), 55);
  EXPECT_EQ(message.at("sensors").at(0).at("state"), "ok");
  message = message_of(Json::array({sensor("left", 5)}), Json::array({grasp}), kMaxAgeMs);
  EXPECT_EQ(message.at("sensors").at(0).at("state"), "stale");
  EXPECT_EQ(message.at("grasps").at(0).at("state"), "stale");
}

TEST(LiveMessage, PassesAYoungMarginOn) {
  const Json message = message_of(Json::array({sensor("left", 5)}));
  EXPECT_EQ(message.at("slipd"), "ok");
  EXPECT_EQ(message.at("sensors").at(0), sensor("left", 5));
}

TEST(LiveMessage, HasNoMarginThatIsTooOld) {
  for (const Json& age : {Json(100.1), Json(1e9), Json(nullptr), Json("young")}) {
    const Json estimate = message_of(Json::array({sensor("left", age)})).at("sensors").at(0);
    EXPECT_EQ(estimate.at("state"), "stale") << age;
    for (const char* key : {"gamma", "sigma", "gamma_low", "class", "grip_increase_n", "sliding", "normal_n",
                            "center_mm", "truth"})
      EXPECT_TRUE(estimate.at(key).is_null()) << key;
    EXPECT_EQ(estimate.at("health"), "unknown");
    EXPECT_EQ(estimate.at("age_ms"), age);
  }
}

TEST(LiveMessage, WithoutFramesARaisedAlertStandsAndNoneIsUnknown) {
  const std::pair<const char*, const char*> alerts[] = {
      {"none", "unknown"}, {"unknown", "unknown"}, {"warn", "warn"}, {"slip", "slip"}};
  for (const auto& [alert, after] : alerts) {
    for (const char* state : {"ok", "fault"}) {
      Json young = sensor("left", 5, state);
      young["alert"] = alert;
      EXPECT_EQ(message_of(Json::array({young})).at("sensors").at(0).at("alert"), alert);
      Json old = young;
      old["age_ms"] = 500;
      EXPECT_EQ(message_of(Json::array({old})).at("sensors").at(0).at("alert"), after) << state;
      const std::string before = message_of(Json::array({young})).dump();
      const Json away = Json::parse(away_message("gone", before)).at("sensors").at(0);
      EXPECT_EQ(away.at("alert"), after);
      EXPECT_EQ(away.at("state"), "disconnected");
      EXPECT_EQ(away.at("sensor"), "left");
      for (const char* key : {"gamma", "sigma", "gamma_low", "normal_n", "age_ms", "sliding", "truth"})
        EXPECT_TRUE(away.at(key).is_null()) << key;
    }
  }
}

TEST(LiveMessage, HasNoMarginOutsideStateOk) {
  for (const char* state : {"learning", "fault", "out_of_model", "a state of a newer slipd"}) {
    const Json estimate = message_of(Json::array({sensor("left", 5, state)})).at("sensors").at(0);
    EXPECT_TRUE(estimate.at("gamma").is_null());
    EXPECT_EQ(estimate.at("state"), state);
  }
  EXPECT_EQ(message_of(Json::array({sensor("left", 500, "fault")})).at("sensors").at(0).at("state"), "fault");
}

TEST(LiveMessage, AGraspIsAsOldAsItsOldestSensor) {
  const auto grasp = [](const Json& members) {
    return Json{{"grasp", "g"}, {"sensors", members}, {"state", "ok"},
                {"gamma", 0.3}, {"alert", "none"},    {"first", {{"sensor", "a"}, {"gamma", 0.2}}}};
  };
  const Json sensors = Json::array({sensor("a", 5), sensor("b", 500), sensor("c", 20)});
  Json of = message_of(sensors, Json::array({grasp(Json::array({"a", "c"}))})).at("grasps").at(0);
  EXPECT_EQ(of.at("state"), "ok");
  EXPECT_EQ(of.at("age_ms"), 20);
  EXPECT_EQ(of.at("simulated"), true);
  for (const Json& members : {Json::array({"a", "b"}), Json::array({"a", "nobody"}), Json::array()}) {
    of = message_of(sensors, Json::array({grasp(members)})).at("grasps").at(0);
    EXPECT_EQ(of.at("state"), "stale") << members;
    EXPECT_TRUE(of.at("gamma").is_null() && of.at("first").is_null());
  }
}

TEST(LiveMessage, RefusesWhatIsNoAnswer) {
  for (const char* text : {"", "{}", "[]", R"({"sensors":1,"grasps":2})", R"({"sensors":[{}],"grasps":[]})"})
    EXPECT_ANY_THROW(live_message({text}, kMaxAgeMs)) << text;
}

TEST(LiveMessage, SaysWhySlipdIsAway) {
  const Json message = Json::parse(away_message("it \"sleeps\"\xff", ""));
  EXPECT_EQ(message.at("slipd"), "away");
  EXPECT_TRUE(message.at("sensors").empty());
}

}  // namespace
}  // namespace slipd::web
