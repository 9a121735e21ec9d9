// What slipd-grip makes of an estimate.
#include "grip/reading.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/grip/held.hpp"

namespace slipd::grip {
namespace {

slipd_estimate told(int state, int alert) {
  slipd_estimate now{};
  now.state = state;
  now.alert = alert;
  now.sliding = SLIPD_SLIDING_UNKNOWN;
  now.valid_until_ns = std::numeric_limits<std::int64_t>::max();
  now.gamma = state == SLIPD_STATE_OK ? 0.6 : kNone;
  now.gamma_low = now.sigma = now.grip_increase_n = now.time_to_slip_s = kNone;
  return now;
}

TEST(ReadingOfAnEstimate, HasTheMarginInStateOkWhileAlertsAreWatchedAndNowhereElse) {
  EXPECT_TRUE(reading_of(told(SLIPD_STATE_OK, SLIPD_ALERT_NONE), false).known);
  EXPECT_FALSE(reading_of(told(SLIPD_STATE_OK, SLIPD_ALERT_UNKNOWN), false).known);
  for (const int state :
       {SLIPD_STATE_NO_CONTACT, SLIPD_STATE_LEARNING, SLIPD_STATE_OUT_OF_MODEL, SLIPD_STATE_NO_SHEAR,
        SLIPD_STATE_UNZEROED, SLIPD_STATE_STALE, SLIPD_STATE_FAULT, SLIPD_STATE_DISCONNECTED})
    EXPECT_FALSE(reading_of(told(state, SLIPD_ALERT_NONE), false).known) << state;
}

TEST(ReadingOfAnEstimate, SlipsByAnAlertInEachStateWithAFrame) {
  for (const int state : {SLIPD_STATE_OK, SLIPD_STATE_LEARNING, SLIPD_STATE_OUT_OF_MODEL,
                          SLIPD_STATE_NO_SHEAR, SLIPD_STATE_UNZEROED})
    EXPECT_TRUE(reading_of(told(state, SLIPD_ALERT_SLIP), false).slips) << state;
  EXPECT_FALSE(reading_of(told(SLIPD_STATE_OK, SLIPD_ALERT_WARN), false).slips);
  EXPECT_TRUE(reading_of(told(SLIPD_STATE_OK, SLIPD_ALERT_NONE), true).slips);
}

// A gripper that closed on an object, which then slipped.
Held reacting() {
  Held held;
  held.step(reading_of(told(SLIPD_STATE_NO_CONTACT, SLIPD_ALERT_NONE), false), Wish::close);
  held.step(reading_of(told(SLIPD_STATE_OK, SLIPD_ALERT_NONE), false));
  held.step(reading_of(told(SLIPD_STATE_OK, SLIPD_ALERT_SLIP), false));
  EXPECT_EQ(held.law.state(), State::reacting);
  return held;
}

// A raised alert stands for as long as nothing shows that it is over, and would raise the force to its limit.
TEST(ReadingOfAnEstimate, DoesNotSlipOnByAnAlertFromBeforeSlipdOrTheSensorWent) {
  for (const int state : {SLIPD_STATE_STALE, SLIPD_STATE_FAULT, SLIPD_STATE_DISCONNECTED}) {
    Held held = reacting();
    held.steps(reading_of(told(state, SLIPD_ALERT_SLIP), false), 5);
    EXPECT_EQ(held.law.state(), State::firm) << state;
    EXPECT_EQ(held.law.force_n(), held.settings.firm_n) << state;
  }
}

TEST(ReadingOfAnEstimate, DoesNotSlipOnByAnAlertWithoutAMarginWhileTheObjectIsSeenToStand) {
  Held held = reacting();
  slipd_estimate stands = told(SLIPD_STATE_LEARNING, SLIPD_ALERT_SLIP);
  stands.sliding = SLIPD_SLIDING_NONE;
  held.steps(reading_of(stands, false), 5);
  EXPECT_EQ(held.law.state(), State::firm);
  EXPECT_EQ(held.law.force_n(), held.settings.firm_n);
  stands.sliding = SLIPD_SLIDING_TRANSLATION;
  held.step(reading_of(stands, false));
  EXPECT_EQ(held.law.state(), State::reacting);
  EXPECT_GT(held.law.force_n(), held.settings.firm_n);
}

// With a margin it may be about to slip as a whole: nothing slides yet.
TEST(ReadingOfAnEstimate, SlipsByAnAlertOfTheMarginWhateverSlides) {
  slipd_estimate stands = told(SLIPD_STATE_OK, SLIPD_ALERT_SLIP);
  stands.sliding = SLIPD_SLIDING_NONE;
  EXPECT_TRUE(reading_of(stands, false).slips);
}

}  // namespace
}  // namespace slipd::grip
