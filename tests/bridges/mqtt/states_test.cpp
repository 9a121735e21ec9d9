// Which state stands, and when it is said: at changes, once a period, and when slipd falls silent.
#include "bridges/mqtt/states.hpp"

#include <gmock/gmock.h>

#include <cstring>
#include <limits>

namespace slipd::mqtt {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class TheStates : public ::testing::Test {
 protected:
  static slipd_estimate estimate_of(const char* name, int state, int alert, double age_s = 0) {
    slipd_estimate estimate{};
    std::strcpy(estimate.name, name);
    estimate.state = state;
    estimate.alert = alert;
    estimate.age_s = age_s;
    estimate.gamma = 0.5;
    return estimate;
  }
  bool take(const char* name, int state, int alert, milliseconds at, double age_s = 0) {
    slipd_estimate estimate = estimate_of(name, state, alert, age_s);
    return states_.take(estimate, "{}", start_ + at);
  }
  // "left ok none", …
  std::vector<std::string> said(milliseconds at) {
    std::vector<std::string> lines;
    states_.say_due(start_ + at, [&](const States::State& state) {
      lines.push_back(std::string(state.estimate.name) + " " + slipd_state_name(state.estimate.state) + " " +
                      slipd_alert_name(state.estimate.alert));
    });
    return lines;
  }
  milliseconds next() const { return std::chrono::duration_cast<milliseconds>(states_.next() - start_); }

  States::Time start_{std::chrono::hours(1)};
  States states_{{milliseconds(500), seconds(10)}};
};

TEST_F(TheStates, AStateIsSaidAtOnceAndAgainWhenStateOrAlertChange) {
  EXPECT_TRUE(take("left", SLIPD_STATE_OK, SLIPD_ALERT_NONE, milliseconds(0)));
  EXPECT_THAT(said(milliseconds(0)), ElementsAre("left ok none"));
  EXPECT_FALSE(take("left", SLIPD_STATE_OK, SLIPD_ALERT_NONE, milliseconds(100)));
  EXPECT_THAT(said(milliseconds(100)), IsEmpty());
  EXPECT_TRUE(take("left", SLIPD_STATE_OK, SLIPD_ALERT_WARN, milliseconds(200)));
  EXPECT_THAT(said(milliseconds(200)), ElementsAre("left ok warn"));
  EXPECT_TRUE(take("left", SLIPD_STATE_LEARNING, SLIPD_ALERT_WARN, milliseconds(300)));
  EXPECT_THAT(said(milliseconds(300)), ElementsAre("left learning warn"));
}

TEST_F(TheStates, AStateThatHoldsIsSaidOnceAPeriod) {
  for (int i = 0; i < 100; ++i) {
    take("left", SLIPD_STATE_OK, SLIPD_ALERT_NONE, milliseconds(100 * i));
    EXPECT_EQ(said(milliseconds(100 * i)).size(), i == 0 ? 1U : 0U);
  }
  take("left", SLIPD_STATE_OK, SLIPD_ALERT_NONE, seconds(10));
  EXPECT_EQ(next(), seconds(10));
  EXPECT_THAT(said(seconds(10)), ElementsAre("left ok none"));
}

TEST_F(TheStates, SilenceMakesAStateStaleAndNoAlertUnknown) {
  take("left", SLIPD_STATE_OK, SLIPD_ALERT_NONE, milliseconds(0), 0.1);
  take("right", SLIPD_STATE_NO_CONTACT, SLIPD_ALERT_WARN, milliseconds(50));
  said(milliseconds(50));
  EXPECT_EQ(next(), milliseconds(400));
  EXPECT_THAT(said(milliseconds(399)), IsEmpty());
  EXPECT_THAT(said(milliseconds(400)), ElementsAre("left stale unknown"));
  EXPECT_THAT(said(milliseconds(550)), ElementsAre("right stale warn"));
  EXPECT_THAT(said(milliseconds(5000)), IsEmpty());
  EXPECT_THAT(said(seconds(11)), ElementsAre("left stale unknown", "right stale warn"));
  take("left", SLIPD_STATE_OK, SLIPD_ALERT_NONE, seconds(12));
  EXPECT_THAT(said(seconds(12)), ElementsAre("left ok none"));
}

TEST_F(TheStates, AFaultStaysOneInSilence) {
  take("left", SLIPD_STATE_FAULT, SLIPD_ALERT_NONE, milliseconds(0));
  said(milliseconds(0));
  EXPECT_THAT(said(milliseconds(500)), ElementsAre("left fault unknown"));
}

TEST_F(TheStates, WithoutAFrameAnEstimateIsOldAtOnce) {
  take("left", SLIPD_STATE_STALE, SLIPD_ALERT_NONE, milliseconds(0), std::numeric_limits<double>::infinity());
  EXPECT_THAT(said(milliseconds(0)), ElementsAre("left stale unknown"));
  EXPECT_EQ(next(), seconds(10));
}

TEST_F(TheStates, ARaisedAlertStandsWhileSlipdIsAwayAndUntilFramesShowItsEnd) {
  take("left", SLIPD_STATE_OK, SLIPD_ALERT_SLIP, milliseconds(0));
  take("right", SLIPD_STATE_OK, SLIPD_ALERT_NONE, milliseconds(0));
  said(milliseconds(0));
  for (const char* name : {"left", "right", "new"}) states_.lose(name, "{}");
  EXPECT_THAT(said(milliseconds(10)), ElementsAre("left disconnected slip", "new disconnected unknown",
                                                  "right disconnected unknown"));
  slipd_estimate back = estimate_of("left", SLIPD_STATE_STALE, SLIPD_ALERT_UNKNOWN);
  EXPECT_TRUE(states_.take(back, "{}", start_ + milliseconds(20)));
  EXPECT_EQ(back.alert, SLIPD_ALERT_SLIP);
  EXPECT_EQ(states_.standing_alert("left"), SLIPD_ALERT_SLIP);
  EXPECT_THAT(said(milliseconds(20)), ElementsAre("left stale slip"));
  take("left", SLIPD_STATE_OK, SLIPD_ALERT_NONE, milliseconds(30));
  EXPECT_THAT(said(milliseconds(30)), ElementsAre("left ok none"));
  EXPECT_EQ(states_.standing_alert("left"), SLIPD_ALERT_NONE);
}

TEST_F(TheStates, AnAlertThatWasRecordedBeforeStandsUntilFramesShowItsEnd) {
  states_ = States({milliseconds(500), seconds(10)}, [](const std::string& name) {
    return name == "left" ? int{SLIPD_ALERT_SLIP} : int{SLIPD_ALERT_NONE};
  });
  EXPECT_EQ(states_.standing_alert("left"), SLIPD_ALERT_SLIP);
  EXPECT_EQ(states_.standing_alert("right"), SLIPD_ALERT_NONE);
  take("left", SLIPD_STATE_STALE, SLIPD_ALERT_UNKNOWN, milliseconds(0));
  take("right", SLIPD_STATE_STALE, SLIPD_ALERT_UNKNOWN, milliseconds(0));
  EXPECT_THAT(said(milliseconds(0)), ElementsAre("left stale slip", "right stale unknown"));
  take("left", SLIPD_STATE_OK, SLIPD_ALERT_NONE, milliseconds(100));
  EXPECT_EQ(states_.standing_alert("left"), SLIPD_ALERT_NONE);
}

TEST_F(TheStates, AnotherBrokerGetsAllOfThem) {
  take("left", SLIPD_STATE_OK, SLIPD_ALERT_NONE, milliseconds(0));
  take("right", SLIPD_STATE_OK, SLIPD_ALERT_NONE, milliseconds(0));
  said(milliseconds(0));
  states_.renew();
  EXPECT_LE(next(), milliseconds(0));
  EXPECT_EQ(said(milliseconds(1)).size(), 2U);
}

TEST_F(TheStates, WhatIsForgottenIsSaidNoMore) {
  take("left", SLIPD_STATE_OK, SLIPD_ALERT_NONE, milliseconds(0));
  take("right", SLIPD_STATE_OK, SLIPD_ALERT_NONE, milliseconds(0));
  EXPECT_THAT(states_.forget([](const std::string& name) { return name == "left"; }), ElementsAre("left"));
  EXPECT_THAT(said(milliseconds(0)), ElementsAre("right ok none"));
}

}  // namespace
}  // namespace slipd::mqtt
