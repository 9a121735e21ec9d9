// The messages fit the schema that is in the tree, and carry a margin only in state ok and while it is young.
#include "bridges/mqtt/messages.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "schema/json_text.hpp"
#include "schema/schema.hpp"

namespace slipd::mqtt {
namespace {

using nlohmann::json;

constexpr const char* kSent =
    R"({"sensor":"left","seq":12,"time_ns":1790000000000000000,"state":"ok","gamma":0.62,"sigma":0.01,"class":4,)"
    R"("gamma_low":0.59,"normal_n":2.1,"shear_n":0.36,"torque_nmm":0.4,"friction":0.45,"time_to_slip_ms":20.5,)"
    R"("grip_increase_n":0.5,"alert":"warn","alert_cause":"margin","sliding":"none","health":"good","simulated":true,)"
    R"("dropped":0})";

slipd_estimate estimate_in(int state, double valid_for_s) {
  slipd_estimate estimate{};
  std::strcpy(estimate.name, "left");
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  estimate.state = state;
  estimate.alert = SLIPD_ALERT_WARN;
  estimate.gamma = state == SLIPD_STATE_OK ? 0.62 : std::numeric_limits<double>::quiet_NaN();
  estimate.valid_until_ns =
      now.tv_sec * 1'000'000'000LL + now.tv_nsec + static_cast<std::int64_t>(1e9 * valid_for_s);
  return estimate;
}

json checked(const std::string& text, const std::string& kind) {
  std::ifstream file(SLIPD_SOURCE_DIR "/bridges/mqtt/messages.schema.json");
  json schema = parse_json_text(std::string{std::istreambuf_iterator<char>(file), {}});
  schema.erase("type");
  schema["$ref"] = "#/$defs/" + kind;
  json value = json::parse(text);
  for (const Problem& problem : check(schema, value)) ADD_FAILURE() << problem.in(kind) << "\n" << text;
  return value;
}

bridges::Inventory inventory() {
  return {"0.1.0", {{"left", "sim", "array3", 16, 100, true}}, {{"gripper", {"left"}}}};
}

TEST(MqttMessages, AnEstimateIsWhatSlipdSent) {
  const json sent = checked(estimate_message(estimate_in(SLIPD_STATE_OK, 100), kSent), "estimate");
  EXPECT_EQ(sent, json::parse(kSent));
}

TEST(MqttMessages, AnEstimateThatIsTooOldHasNoMargin) {
  const json sent = checked(estimate_message(estimate_in(SLIPD_STATE_STALE, -1), kSent), "estimate");
  EXPECT_EQ(sent.at("state"), "stale");
  for (const char* key : {"gamma", "class", "gamma_low", "grip_increase_n", "time_to_slip_ms"})
    EXPECT_TRUE(sent.at(key).is_null()) << key;
  EXPECT_EQ(sent.at("normal_n"), 2.1);
}

TEST(MqttMessages, AnotherStateThanOkHasNoMarginWhateverSlipdSent) {
  const json sent = checked(estimate_message(estimate_in(SLIPD_STATE_FAULT, 100), kSent), "estimate");
  EXPECT_EQ(sent.at("state"), "fault");
  EXPECT_TRUE(sent.at("gamma").is_null());
}

TEST(MqttMessages, AnAlertIsIdentifiedAndComplete) {
  const json sent = checked(alert_message(kSent, std::string(32, 'a'), 7, 2), "alert");
  EXPECT_EQ(sent.at("number"), 7);
  EXPECT_EQ(sent.at("dropped"), 2);
  EXPECT_EQ(sent.at("alert"), "warn");
  EXPECT_EQ(sent.at("gamma"), 0.62);
  checked(alert_message("{}", std::string(32, 'a'), 1, 0), "alert");
  checked(alert_message("no JSON", std::string(32, 'a'), 1, 0), "alert");
}

constexpr std::chrono::milliseconds kValid{20'000};

TEST(MqttMessages, AStateSaysHowLongItHolds) {
  const json sent = checked(state_message(estimate_in(SLIPD_STATE_OK, 100), kSent, kValid), "state");
  EXPECT_EQ(sent.at("state"), "ok");
  EXPECT_EQ(sent.at("valid_for_ms"), 20'000);
}

TEST(MqttMessages, AStateWithoutFramesKnowsNeitherHealthNorSlidingNorThatThereIsNoAlert) {
  for (const auto& [alert, name] : {std::pair{SLIPD_ALERT_NONE, "unknown"}, {SLIPD_ALERT_SLIP, "slip"}}) {
    slipd_estimate estimate = estimate_in(SLIPD_STATE_OK, 100);
    estimate.alert = alert;
    grow_old(estimate);
    const json sent = checked(state_message(estimate, kSent, kValid), "state");
    EXPECT_EQ(sent.at("state"), "stale");
    EXPECT_EQ(sent.at("alert"), name);
    EXPECT_EQ(sent.at("health"), "unknown");
    EXPECT_TRUE(sent.at("sliding").is_null());
  }
}

TEST(MqttMessages, AStateOfASlipdThatIsAwayFitsTheSchema) {
  slipd_estimate away = estimate_in(SLIPD_STATE_DISCONNECTED, -1);
  for (const auto& [text, kind] :
       {std::pair{away_text("left", 5), "state"},
        std::pair{away_text(bridges::GraspFacts{"left", {"a"}}, 5), "grasp_state"}}) {
    const json sent = checked(state_message(away, text, kValid), kind);
    EXPECT_EQ(sent.at("state"), "disconnected");
    EXPECT_EQ(sent.at("alert"), "warn");
    EXPECT_EQ(sent.at("time_ns"), 5);
  }
}

TEST(MqttMessages, TheStatusSaysWhetherSlipdServes) {
  const AlertCounts alerts{std::string(32, 'a'), 7, 2, 1};
  const json there = checked(online_message({"0.1.0", inventory(), alerts, "", kValid}, 5), "status");
  EXPECT_EQ(there.at("slipd"), "0.1.0");
  EXPECT_EQ(there.at("sensors").at(0).at("name"), "left");
  const json away = checked(online_message({"0.1.0", std::nullopt, alerts, "gone", kValid}, 5), "status");
  EXPECT_TRUE(away.at("slipd").is_null());
  EXPECT_TRUE(checked(offline_message(0), "status").at("time_ns").is_null());
  EXPECT_EQ(checked(seen_message({"0.1.0", inventory(), alerts, "", kValid}, 5), "seen").at("version"),
            "0.1.0");
}

TEST(MqttMessages, TheSummaryHasAMarginOnlyWhereItIsKnown) {
  Summary summary;
  summary.sensors = {{"left", {"ok", "none", 0.5, 0.4}}, {"right", {}}};
  summary.grasps = {{"gripper", {"ok", "warn", 0.3, 0.2}}};
  summary.alerts_last_hour = 3;
  summary.period_s = 10;
  const json sent = checked(summary_message({"0.1.0", inventory(), {}, "", kValid}, summary, 5), "summary");
  EXPECT_EQ(sent.at("sensors").at(0).at("gamma"), 0.5);
  EXPECT_EQ(sent.at("sensors").at(0).at("gamma_min"), 0.4);
  EXPECT_TRUE(sent.at("sensors").at(1).at("gamma").is_null());
  EXPECT_TRUE(sent.at("sensors").at(1).at("gamma_min").is_null());
  EXPECT_EQ(sent.at("grasps").at(0).at("gamma_min"), 0.2);
  EXPECT_EQ(sent.at("alerts_last_hour"), 3);
  summary.alerts_last_hour.reset();
  EXPECT_TRUE(json::parse(summary_message({"0.1.0", inventory(), {}, "", kValid}, summary, 5))
                  .at("alerts_last_hour")
                  .is_null());
}

constexpr double kMaxAge = 0.5;

// slipd's answer to `gamma` with the grasp "cup" of left and right.
std::string answer(const json& left, const json& right, const json& cup = json::object()) {
  json grasp{{"grasp", "cup"},      {"sensors", {"left", "right"}},
             {"state", "ok"},       {"gamma", 0.5},
             {"sigma", 0.01},       {"gamma_low", 0.45},
             {"alert", "warn"},     {"alert_cause", "margin"},
             {"sliding", "none"},   {"first", {{"sensor", "left"}, {"gamma", 0.5}}},
             {"normal_n", 4.0},     {"shear_n", 1.0},
             {"friction", nullptr}, {"grip_increase_n", 0.5}};
  grasp.update(cup);
  return json{{"sensors", {left, right}}, {"grasps", {grasp}}}.dump();
}

json sensor_of(const char* name, double age_ms, bool simulated = false) {
  return {{"sensor", name},
          {"age_ms", age_ms},
          {"time_ns", 1'790'000'000'000'000'000 - std::int64_t(1e6 * age_ms)},
          {"simulated", simulated}};
}

TEST(MqttMessages, AGraspIsAsOldAsTheOldestOfItsSensors) {
  const auto grasps = grasps_of(answer(sensor_of("left", 100), sensor_of("right", 300, true)), kMaxAge, 1000);
  ASSERT_EQ(grasps.size(), 1U);
  const slipd_estimate& grasp = grasps[0].estimate;
  EXPECT_STREQ(grasp.name, "cup");
  EXPECT_EQ(grasp.state, SLIPD_STATE_OK);
  EXPECT_EQ(grasp.alert, SLIPD_ALERT_WARN);
  EXPECT_DOUBLE_EQ(grasp.gamma, 0.5);
  EXPECT_NEAR(static_cast<double>(grasp.valid_until_ns - 1000), 0.2e9, 10);
  const json text = json::parse(grasps[0].text);
  EXPECT_EQ(text.at("age_ms"), 300);
  EXPECT_EQ(text.at("time_ns"), 1'789'999'999'700'000'000);
  EXPECT_EQ(text.at("simulated"), true);
}

TEST(MqttMessages, AGraspOfSensorsThatAreSilentOrUnknownHasNoMargin) {
  const json silent{{"sensor", "right"}, {"age_ms", nullptr}, {"time_ns", nullptr}, {"simulated", false}};
  for (const json& right : {sensor_of("right", 501), silent, sensor_of("other", 1)}) {
    const auto grasps = grasps_of(answer(sensor_of("left", 1), right), kMaxAge, 0);
    ASSERT_EQ(grasps.size(), 1U);
    EXPECT_EQ(grasps[0].estimate.state, SLIPD_STATE_STALE);
    const json sent = checked(estimate_message(grasps[0].estimate, grasps[0].text), "grasp_estimate");
    for (const char* key : {"gamma", "gamma_low", "grip_increase_n", "first"})
      EXPECT_TRUE(sent.at(key).is_null()) << key;
    EXPECT_EQ(sent.at("state"), "stale");
  }
}

TEST(MqttMessages, MessagesOfAGraspFitTheSchema) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const auto grasps = grasps_of(answer(sensor_of("left", 1), sensor_of("right", 1)), 1000,
                                now.tv_sec * 1'000'000'000LL + now.tv_nsec);
  ASSERT_EQ(grasps.size(), 1U);
  const auto& [estimate, text] = grasps[0];
  EXPECT_EQ(checked(estimate_message(estimate, text), "grasp_estimate").at("gamma"), 0.5);
  EXPECT_EQ(checked(state_message(estimate, text, kValid), "grasp_state").at("alert"), "warn");
  const json alert = checked(alert_message(text, std::string(32, 'a'), 7, 2), "grasp_alert");
  EXPECT_EQ(alert.at("grasp"), "cup");
  EXPECT_EQ(alert.at("number"), 7);
  EXPECT_EQ(alert.at("first").at("sensor"), "left");
}

TEST(MqttMessages, AnAnswerThatIsNoneHasNoGrasps) {
  for (const char* text :
       {"", "[]", "no JSON", R"({"grasps":[1,{},{"grasp":3},{"grasp":""}]})", R"({"grasps":{"grasp":1}})"})
    EXPECT_TRUE(grasps_of(text, kMaxAge, 0).empty()) << text;
  const auto odd = grasps_of(
      answer(sensor_of("left", 1), sensor_of("right", 1), {{"state", 7}, {"alert", "x"}}), kMaxAge, 0);
  ASSERT_EQ(odd.size(), 1U);
  EXPECT_EQ(odd[0].estimate.state, SLIPD_STATE_FAULT);
  EXPECT_EQ(odd[0].estimate.alert, SLIPD_ALERT_SLIP);
  EXPECT_TRUE(std::isnan(odd[0].estimate.gamma));
}

TEST(MqttMessages, TheHashIsThatOfSensorsAndGrasps) {
  bridges::Inventory other = inventory();
  EXPECT_EQ(inventory_hash(other), inventory_hash(inventory()));
  other.version = "9";
  EXPECT_EQ(inventory_hash(other), inventory_hash(inventory()));
  other.sensors[0].rate_hz = 50;
  EXPECT_NE(inventory_hash(other), inventory_hash(inventory()));
}

}  // namespace
}  // namespace slipd::mqtt
