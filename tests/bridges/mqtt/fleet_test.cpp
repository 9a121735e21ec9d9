// The line of a gripper: what retained topics say, and nothing that could be mistaken for a margin when it is
// not known.
#include "bridges/mqtt/fleet.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "bridges/mqtt/messages.hpp"

namespace slipd::mqtt {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::int64_t kStart = 1'790'000'000'000'000'000;
constexpr double kPeriod = 10;

Moment after(double passed_s) {
  const auto passed = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * passed_s));
  return {std::chrono::steady_clock::time_point(std::chrono::hours(1)) + passed, kStart + passed.count()};
}

Gripper gripper() {
  return {"0.1.0",
          bridges::Inventory{
              "0.1.0",
              {{"left", "sim", "array3", 16, 100, true}, {"right", "usb", "array3", 16, 100, false}},
              {{"cup", {"left", "right"}}}},
          {std::string(32, 'a'), 7, 2, 1},
          "",
          std::chrono::seconds(20)};
}

// What slipd-mqtt publishes, in its own words, to the Fleet under test.
class AFleet : public ::testing::Test {
 protected:
  void send(const std::string& topic, const std::string& payload, bool retained = false, double at_s = 0) {
    fleet_.take("slipd/" + topic, payload, retained, after(at_s));
  }
  void status(const std::string& host, const Gripper& facts = gripper()) {
    send(host + "/status", online_message(facts, kStart));
  }
  void state(const std::string& topic, int state, int alert = SLIPD_ALERT_NONE) {
    slipd_estimate estimate{};
    estimate.state = state;
    estimate.alert = alert;
    json text{{"state", "ok"}, {"alert", slipd_alert_name(alert)}, {"simulated", true}};
    send(topic + "/state", state_message(estimate, text.dump(), std::chrono::seconds(20)));
  }
  void summary(const std::string& host, double left, double right, double cup, bool retained = false,
               double at_s = 0) {
    Summary all;
    all.sensors = {{"left", {"ok", "none", left, left}}, {"right", {"ok", "none", right, right}}};
    all.grasps = {{"cup", {"ok", "none", cup, cup}}};
    all.alerts_last_hour = 3;
    all.period_s = kPeriod;
    send(host + "/summary", summary_message(gripper(), all, kStart), retained, at_s);
    send(host + "/seen", seen_message(gripper(), kStart), retained, at_s);
  }
  // A gripper whose three margins are known.
  void serve(const std::string& host) {
    status(host);
    for (const char* name : {"left", "right", "cup"}) state(host + "/" + name, SLIPD_STATE_OK);
    summary(host, 0.6, 0.4, 0.5);
  }
  json line(const std::string& host = "g1", double at_s = 0) const {
    return json::parse(fleet_.line(host, after(at_s)));
  }
  Fleet fleet_{"slipd"};
};

TEST_F(AFleet, AGripperShowsItsLeastMarginAndItsAlerts) {
  serve("g1");
  const json got = line();
  EXPECT_EQ(got.at("status"), "online");
  EXPECT_EQ(got.at("state"), "ok");
  EXPECT_EQ(got.at("gamma"), 0.4);
  EXPECT_EQ(got.at("gamma_of"), "right");
  EXPECT_EQ(got.at("alerts_last_hour"), 3);
  EXPECT_EQ(got.at("alerts_waiting"), 2);
  EXPECT_EQ(got.at("alerts_dropped"), 1);
  EXPECT_EQ(got.at("version"), "0.1.0");
  EXPECT_EQ(got.at("simulated"), true);
  EXPECT_TRUE(got.at("offline_since_ns").is_null());
}

TEST_F(AFleet, ASensorWithoutAMarginTakesTheGrippers) {
  for (int state_now = SLIPD_STATE_OK; state_now <= SLIPD_STATE_DISCONNECTED; ++state_now) {
    serve("g1");
    state("g1/left", state_now, SLIPD_ALERT_WARN);
    const json got = line();
    const bool harmless = state_now == SLIPD_STATE_OK || state_now == SLIPD_STATE_NO_CONTACT;
    EXPECT_EQ(got.at("gamma").is_number(), harmless) << got;
    EXPECT_EQ(got.at("state"), harmless ? "ok" : slipd_state_name(state_now));
    EXPECT_EQ(got.at("state_of") == "left", state_now != SLIPD_STATE_NO_CONTACT) << got;
    EXPECT_EQ(got.at("alert"), "warn");
  }
}

TEST_F(AFleet, NobodyInContactIsNoMargin) {
  serve("g1");
  for (const char* name : {"left", "right", "cup"}) state(std::string("g1/") + name, SLIPD_STATE_NO_CONTACT);
  EXPECT_EQ(line().at("state"), "no_contact");
  EXPECT_TRUE(line().at("gamma").is_null());
}

TEST_F(AFleet, ASummaryWithoutTheMarginOfASensorThatHasOneIsNoMargin) {
  serve("g1");
  summary("g1", std::numeric_limits<double>::quiet_NaN(), 0.4, 0.5);
  EXPECT_TRUE(line().at("gamma").is_null());
}

TEST_F(AFleet, ASummaryThatIsTooOldSaysNothing) {
  serve("g1");
  EXPECT_TRUE(line("g1", 2 * kPeriod - 0.1).at("gamma").is_number());
  const json got = line("g1", 2 * kPeriod + 0.1);
  EXPECT_TRUE(got.at("gamma").is_null());
  EXPECT_TRUE(got.at("alerts_last_hour").is_null());
  EXPECT_EQ(got.at("state"), "stale");
}

TEST_F(AFleet, TheAgeOfAKeptSummaryIsThatOfItsTime) {
  serve("g1");
  summary("g1", 0.6, 0.4, 0.5, true, 5);
  EXPECT_TRUE(line("g1", 5).at("gamma").is_number());
  EXPECT_TRUE(line("g1", 2 * kPeriod + 1).at("gamma").is_null());
  summary("g1", 0.6, 0.4, 0.5, true, 3600);  // kept for an hour, or clocks that disagree
  EXPECT_TRUE(line("g1", 3600).at("gamma").is_null());
  summary("g1", 0.6, 0.4, 0.5, true, -3600);
  EXPECT_TRUE(line("g1", -3600).at("gamma").is_null());
}

TEST_F(AFleet, OfflineSinceTheEndThatWasAnnouncedElseSinceTheLastSummary) {
  serve("g1");
  send("g1/status", offline_message(kStart + 5));
  json got = line();
  EXPECT_EQ(got.at("status"), "offline");
  EXPECT_EQ(got.at("offline_since_ns"), kStart + 5);
  EXPECT_TRUE(got.at("gamma").is_null());
  EXPECT_EQ(got.at("alert"), "unknown");
  EXPECT_TRUE(got.at("alerts_last_hour").is_null());
  EXPECT_EQ(got.at("version"), "0.1.0");
  send("g1/status", offline_message(0));  // the last will
  EXPECT_EQ(line().at("offline_since_ns"), kStart);
}

TEST_F(AFleet, WithoutSlipdTheGripperIsDisconnected) {
  serve("g1");
  Gripper away = gripper();
  away.slipd.reset();
  away.trouble = "gone";
  status("g1", away);
  EXPECT_EQ(line().at("status"), "online");
  EXPECT_EQ(line().at("state"), "disconnected");
  EXPECT_TRUE(line().at("gamma").is_null());
}

// Worst first: slip, warn, unknown, none.
TEST_F(AFleet, TheAlertIsTheWorstThatStandsAndNoneOnlyWhereAllAreWatched) {
  serve("g1");
  EXPECT_EQ(line().at("alert"), "none");
  state("g1/left", SLIPD_STATE_STALE, SLIPD_ALERT_UNKNOWN);
  EXPECT_EQ(line().at("alert"), "unknown");
  state("g1/right", SLIPD_STATE_OK, SLIPD_ALERT_WARN);
  EXPECT_EQ(line().at("alert"), "warn");
  state("g1/cup", SLIPD_STATE_DISCONNECTED, SLIPD_ALERT_SLIP);
  EXPECT_EQ(line().at("alert"), "slip");
}

TEST_F(AFleet, ASensorThatHasSaidNothingIsNotWatched) {
  serve("g1");
  send("g1/left/state", "");
  EXPECT_EQ(line().at("alert"), "unknown");
}

TEST_F(AFleet, WithoutASummaryNobodyKnowsThatThereIsNoAlert) {
  serve("g1");
  EXPECT_EQ(line("g1", 2 * kPeriod + 0.1).at("alert"), "unknown");
}

TEST_F(AFleet, AGripperThatWentInASlipStaysInIt) {
  for (const int alert : {SLIPD_ALERT_NONE, SLIPD_ALERT_SLIP}) {
    const json expected = alert == SLIPD_ALERT_SLIP ? "slip" : "unknown";
    serve("g1");
    state("g1/left", SLIPD_STATE_OK, alert);
    Gripper away = gripper();
    away.slipd.reset();
    status("g1", away);
    EXPECT_EQ(line().at("alert"), expected);
    send("g1/status", offline_message(0));
    EXPECT_EQ(line().at("alert"), expected);
  }
}

// What has expired at the broker it never sends to one that starts now.
TEST_F(AFleet, ATimeThatStaysSaysSinceWhenAGripperIsOffline) {
  send("g1/status", offline_message(0), true);
  send("g1/seen", seen_message(gripper(), kStart + 7), true);
  const json got = line();
  EXPECT_EQ(got.at("offline_since_ns"), kStart + 7);
  EXPECT_EQ(got.at("version"), "0.1.0");
  EXPECT_EQ(got.at("alert"), "unknown");
}

TEST_F(AFleet, StatesOfSensorsThatTheGripperNoLongerHasDoNotCount) {
  serve("g1");
  state("g1/old", SLIPD_STATE_FAULT, SLIPD_ALERT_SLIP);
  EXPECT_EQ(line().at("state"), "ok");
  EXPECT_EQ(line().at("alert"), "none");
}

TEST_F(AFleet, AGripperIsRemovedWithItsTopics) {
  serve("g1");
  serve("g2");
  EXPECT_THAT(fleet_.grippers(), ElementsAre("g1", "g2"));
  for (const char* kind : {"status", "summary", "seen"}) send(std::string("g1/") + kind, "");
  EXPECT_THAT(fleet_.grippers(), ElementsAre("g2"));
  EXPECT_EQ(line("g1").at("status"), "removed");
}

TEST_F(AFleet, WhatIsNotSlipdMqttsMakesNoMargin) {
  for (const char* topic : {"slipd/g1", "slipd//status", "slipd/g1/left/estimate", "slipd/g1/a/b/state",
                            "slip/g1/status", "slipdx/g1/status", "slipd/", ""})
    EXPECT_EQ(fleet_.take(topic, "{}", false, after(0)), "") << topic;
  EXPECT_THAT(fleet_.grippers(), IsEmpty());
  serve("g1");
  for (const char* kind : {"status", "summary", "left/state"}) {
    for (
        const char* payload :
        {"no JSON", "[]", "1", R"({"status":"online","slipd":"1","sensors":3,"grasps":[1,{"name":2}]})",
         R"({"time_ns":-9223372036854775808,"period_s":"x","sensors":[[]],"alerts":4,"alerts_last_hour":-1})",
         R"({"time_ns":18446744073709551615,"period_s":1e300,"sensors":{"sensor":"left"}})",
         R"({"state":7,"alert":[]})", "\xff\xfe"}) {
      serve("g1");
      send(std::string("g1/") + kind, payload, true);
      EXPECT_TRUE(line().at("gamma").is_null()) << kind << " " << payload << " " << line();
    }
  }
}

}  // namespace
}  // namespace slipd::mqtt
