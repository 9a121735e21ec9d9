// What slipd-grip makes of an estimate.
#include "grip/reading.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "grip/law.hpp"

namespace slipd::grip {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

slipd_estimate told(int state, int alert) {
  slipd_estimate now{};
  now.state = state;
  now.alert = alert;
  now.sliding = SLIPD_SLIDING_UNKNOWN;
  now.valid_until_ns = std::numeric_limits<std::int64_t>::max();
  now.gamma = state == SLIPD_STATE_OK ? 0.6 : kUnknown;
  now.gamma_low = now.sigma = now.grip_increase_n = now.time_to_slip_s = kUnknown;
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
struct Reacting {
  LawSettings settings;
  Law law{settings};
  std::int64_t now_ns = 0;

  Reacting() {
    step(told(SLIPD_STATE_NO_CONTACT, SLIPD_ALERT_NONE), Wish::close);
    step(told(SLIPD_STATE_OK, SLIPD_ALERT_NONE));
    step(told(SLIPD_STATE_OK, SLIPD_ALERT_SLIP));
    EXPECT_EQ(law.state(), State::reacting);
  }
  void step(const slipd_estimate& estimate, Wish wish = Wish::none) {
    law.step(reading_of(estimate, false), wish, true, now_ns += 5'000'000);
  }
};

// A raised alert stands for as long as nothing shows that it is over, and would raise the force to its limit.
TEST(ReadingOfAnEstimate, DoesNotSlipOnByAnAlertFromBeforeSlipdOrTheSensorWent) {
  for (const int state : {SLIPD_STATE_STALE, SLIPD_STATE_FAULT, SLIPD_STATE_DISCONNECTED}) {
    Reacting held;
    for (int i = 0; i < 1000; ++i) held.step(told(state, SLIPD_ALERT_SLIP));
    EXPECT_EQ(held.law.state(), State::firm) << state;
    EXPECT_EQ(held.law.force_n(), held.settings.firm_n) << state;
  }
}

TEST(ReadingOfAnEstimate, DoesNotSlipOnByAnAlertWithoutAMarginWhileTheObjectIsSeenToStand) {
  Reacting held;
  slipd_estimate stands = told(SLIPD_STATE_LEARNING, SLIPD_ALERT_SLIP);
  stands.sliding = SLIPD_SLIDING_NONE;
  for (int i = 0; i < 1000; ++i) held.step(stands);
  EXPECT_EQ(held.law.state(), State::firm);
  EXPECT_EQ(held.law.force_n(), held.settings.firm_n);
  stands.sliding = SLIPD_SLIDING_TRANSLATION;
  held.step(stands);
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
