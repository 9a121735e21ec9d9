// Several fingers: the grasp's margin follows from the sums of their shear forces and of their friction
// limits.
#include "core/grasp/grasp.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace slipd {
namespace {

Estimate finger(double normal_n, double shear_n, double friction) {
  Estimate estimate;
  estimate.state = State::ok;
  estimate.gamma = 1 - shear_n / (friction * normal_n);
  estimate.normal_n = normal_n;
  estimate.shear_n = shear_n;
  estimate.friction = friction;
  return estimate;
}

Estimate in_state(State state) {
  Estimate estimate;
  estimate.state = state;
  return estimate;
}

TEST(Grasp, OneFingersMarginIsItsOwn) {
  const std::array members{finger(2, 0.5, 0.5)};
  EXPECT_DOUBLE_EQ(grasp_estimate(members, 0.5).gamma.value(), 0.5);
}

TEST(Grasp, TheMarginIsOneMinusSumOfShearOverSumOfLimits) {
  const std::array members{finger(2, 0.3, 0.5), finger(4, -0.5, 0.25)};
  const auto margin = grasp_estimate(members, 0.5);
  EXPECT_EQ(margin.state, State::ok);
  EXPECT_DOUBLE_EQ(margin.gamma.value(), 1 - 0.8 / 2.0);
  EXPECT_DOUBLE_EQ(margin.friction.value(), 2.0 / 6);
}

TEST(Grasp, TheAdviceReachesTheTargetExactly) {
  const std::array members{finger(2, 0.7, 0.5), finger(2, 0.7, 0.5)};
  const double more = grasp_estimate(members, 0.6).grip_increase_n.value();
  EXPECT_GT(more, 0);
  const std::array tighter{finger(2 + more / 2, 0.7, 0.5), finger(2 + more / 2, 0.7, 0.5)};
  EXPECT_NEAR(grasp_estimate(tighter, 0.6).gamma.value(), 0.6, 1e-12);
  EXPECT_NEAR(grasp_estimate(tighter, 0.6).grip_increase_n.value(), 0, 1e-12);
}

TEST(Grasp, AFingerInTheAirCarriesNothing) {
  const std::array members{finger(2, 0.5, 0.5), in_state(State::no_contact)};
  EXPECT_DOUBLE_EQ(grasp_estimate(members, 0.5).gamma.value(), 0.5);
  const std::array air{in_state(State::no_contact), in_state(State::no_contact)};
  EXPECT_EQ(grasp_estimate(air, 0.5).state, State::no_contact);
  EXPECT_FALSE(grasp_estimate(air, 0.5).gamma);
}

TEST(Grasp, WithOneFingerUnknownTheGraspIsUnknown) {
  for (const State state :
       {State::learning, State::out_of_model, State::no_shear, State::unzeroed, State::stale, State::fault}) {
    const std::array members{finger(2, 0.5, 0.5), in_state(state)};
    EXPECT_EQ(grasp_estimate(members, 0.5).state, state);
    EXPECT_FALSE(grasp_estimate(members, 0.5).gamma);
  }
  Estimate blind = finger(2, 0.5, 0.5);
  blind.friction.reset();
  const std::array members{finger(2, 0.5, 0.5), blind};
  EXPECT_EQ(grasp_estimate(members, 0.5).state, State::learning);
  EXPECT_FALSE(grasp_estimate({}, 0.5).gamma);
}

// If friction is known to 2 % at each of two equal fingers, it is known to 2 %/sqrt 2 for both.
TEST(Grasp, ErrorsOfTheFingersAreIndependent) {
  std::array members{finger(2, 0.5, 0.5), finger(2, 0.5, 0.5)};
  for (Estimate& each : members) each.friction_sigma = 0.01;
  const Estimate both = grasp_estimate(members, 0.5);
  EXPECT_NEAR(both.friction_sigma.value(), 0.01 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(both.sigma.value(), 0.5 * 0.02 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(both.grip_increase_sigma_n.value(), 4 * 0.02 / std::sqrt(2), 1e-12);
}

TEST(Grasp, AFingerWhoseFrictionIsARangeCountsWithWhatItCanCarry) {
  std::array members{finger(2, 0.3, 0.5), finger(4, 0.5, 0.25)};
  members[1].friction.reset();
  members[1].limit_n = 1;
  members[1].limit_sigma_n = 0.3;
  const Estimate both = grasp_estimate(members, 0.5);
  EXPECT_EQ(both.state, State::ok);
  EXPECT_DOUBLE_EQ(both.gamma.value(), 1 - 0.8 / 2.0);
  EXPECT_DOUBLE_EQ(both.sigma.value(), 0.8 / 2.0 * 0.3 / 2.0);
  EXPECT_FALSE(both.friction) << "it was learnt of one finger only";
}

TEST(Grasp, TheFingerWithTheLeastMarginSlidesFirst) {
  const std::array members{finger(2, 0.1, 0.5), finger(2, 0.4, 0.25), in_state(State::no_contact)};
  const Estimate all = grasp_estimate(members, 0.5);
  EXPECT_EQ(all.first_member, 1);
  EXPECT_DOUBLE_EQ(all.first_gamma.value(), 1 - 0.4 / 0.5);
  EXPECT_GT(all.gamma.value(), all.first_gamma.value()) << "the other one still holds";
}

TEST(Grasp, TheSafeMarginNeedsThatOfEveryFingerAndNoneOfThemHasToBeKnown) {
  std::array members{finger(2, 0.3, 0.5), finger(4, 0.5, 0.25)};
  members[0].limit_low_n = 0.8;
  members[0].gamma_low = 1 - 0.3 / 0.8;
  EXPECT_FALSE(grasp_estimate(members, 0.5).gamma_low);
  members[1].limit_low_n = 0.8;
  members[1].gamma_low = 1 - 0.5 / 0.8;
  members[1].state = State::learning;
  members[1].gamma.reset();
  EXPECT_DOUBLE_EQ(grasp_estimate(members, 0.5).gamma_low.value(), 1 - 0.8 / 1.6);
  EXPECT_FALSE(grasp_estimate(members, 0.5).gamma);
}

constexpr std::int64_t kMillisecond = 1'000'000;

std::array<Estimate, 1> at(std::int64_t time_ns, double gamma, double friction_sigma = 0) {
  std::array members{finger(2, (1 - gamma) * 0.5 * 2, 0.5)};
  members[0].friction_sigma = friction_sigma;
  members[0].published_ns = time_ns;
  return members;
}

TEST(GraspTracker, HasTheHysteresisAndTheLeastDurationOfASensor) {
  GraspTracker judge({});  // warn below 0.4, 0.05 of hysteresis, 2 ms
  EXPECT_EQ(judge.judge(at(0 * kMillisecond, 0.3)).alert, Alert::none);
  EXPECT_EQ(judge.judge(at(1 * kMillisecond, 0.3)).alert, Alert::none);
  EXPECT_EQ(judge.judge(at(2 * kMillisecond, 0.3)).alert, Alert::warn);
  for (int i = 3; i < 20; ++i) EXPECT_EQ(judge.judge(at(i * kMillisecond, 0.42)).alert, Alert::warn) << i;
  for (int i = 20; i < 23; ++i) judge.judge(at(i * kMillisecond, 0.6));
  EXPECT_EQ(judge.judge(at(23 * kMillisecond, 0.6)).alert, Alert::none);
}

TEST(GraspTracker, SigmaLowersTheMarginThatIsCompared) {
  GraspTracker sure({}), unsure({});
  for (int i = 0; i < 5; ++i) {
    sure.judge(at(i * kMillisecond, 0.45));
    unsure.judge(at(i * kMillisecond, 0.45, 0.1));
  }
  EXPECT_EQ(sure.judge(at(5 * kMillisecond, 0.45)).alert, Alert::none);
  EXPECT_EQ(unsure.judge(at(5 * kMillisecond, 0.45, 0.1)).alert, Alert::warn);
}

TEST(GraspTracker, WarnsOfAFingerThatSlidesWhileTheOthersHold) {
  std::array members{finger(4, 0.1, 0.6), finger(1, 0.3, 0.31)};
  GraspTracker judge({});
  EXPECT_EQ(judge.judge(members).alert, Alert::none);
  members[1].alert = Alert::slip;
  const Estimate now = judge.judge(members);
  EXPECT_GT(now.gamma.value(), 0.8);
  EXPECT_EQ(now.alert, Alert::warn);
  EXPECT_EQ(now.alert_cause, AlertCause::margin);
}

TEST(GraspTracker, KnowsOfNoAlertOnlyWhereItHasAMarginOrItsFingersKnowOfNone) {
  std::array members{finger(4, 0.1, 0.6), finger(4, 0.1, 0.6)};
  GraspTracker judge({});
  members[0].alert = members[1].alert = Alert::none;
  EXPECT_EQ(judge.judge(members).alert, Alert::none);
  members[1] = in_state(State::learning);
  members[1].alert = Alert::none;
  EXPECT_EQ(judge.judge(members).alert, Alert::none) << "its pattern watches";
  members[1] = in_state(State::stale);
  const Estimate lost = judge.judge(members);
  EXPECT_EQ(lost.alert, Alert::unknown);
  EXPECT_EQ(lost.alert_cause, AlertCause::none);
}

TEST(GraspTracker, KeepsItsAlertWhenAFingerFallsSilent) {
  std::array members{finger(1, 0.3, 0.31), finger(1, 0.3, 0.31)};
  GraspTracker judge({});
  Alert alert = Alert::unknown;
  for (int i = 0; i < 10; ++i) {
    for (Estimate& member : members) member.published_ns = i * 1'000'000;
    alert = judge.judge(members).alert;
  }
  ASSERT_EQ(alert, Alert::slip);
  members[1] = in_state(State::stale);
  EXPECT_EQ(judge.judge(members).alert, Alert::slip);
}

// Two fingers whose patterns have moved by these shares of what one alone takes for a slide.
std::array<Estimate, 2> watched(double first_moved, double second_moved, double first_torque = 0,
                                double second_torque = 0) {
  std::array members{in_state(State::learning), in_state(State::learning)};
  for (Estimate& member : members) {
    member.sliding = Sliding::disturbed;
    member.alert = Alert::none;
  }
  members[0].pattern = PatternCourse{.moved = first_moved, .along = 0.02, .torque = first_torque};
  members[1].pattern = PatternCourse{.moved = second_moved, .along = 0.02, .torque = second_torque};
  return members;
}

TEST(GraspTracker, SeesASlideThatAllFingersShowThoughNoneIsSureOfIt) {
  GraspTracker judge({});
  EXPECT_EQ(judge.judge(watched(0.6, 0.6)).sliding, Sliding::disturbed);
  const Estimate now = judge.judge(watched(0.75, 0.8));
  EXPECT_EQ(now.sliding, Sliding::translation);
  EXPECT_EQ(now.alert, Alert::slip);
  EXPECT_EQ(now.alert_cause, AlertCause::sliding);
  EXPECT_EQ(judge.judge(watched(0.4, 0.5)).sliding, Sliding::translation) << "it does not flicker";
  EXPECT_EQ(judge.judge(watched(0.2, 0.3)).sliding, Sliding::disturbed);
  EXPECT_EQ(judge.judge(watched(0.6, 0.6)).sliding, Sliding::disturbed);
}

// The object is rigid: what slides over one finger moves over the other.
TEST(GraspTracker, TakesOneFingersPatternForNoSlideOfTheObject) {
  GraspTracker judge({});
  EXPECT_EQ(judge.judge(watched(0.99, 0.1)).sliding, Sliding::disturbed);
  std::array members = watched(0.9, 0.9);
  members[1].pattern.reset();
  EXPECT_EQ(judge.judge(members).sliding, Sliding::disturbed) << "it has no pattern to agree with";
  members[1] = in_state(State::no_contact);
  EXPECT_EQ(judge.judge(members).sliding, Sliding::disturbed) << "one finger alone";
}

TEST(GraspTracker, CallsItATurnWhereFacingFingersFeelOppositeTorques) {
  GraspTracker turning({}), along({});
  EXPECT_EQ(turning.judge(watched(0.9, 0.9, 0.06, -0.05)).sliding, Sliding::rotation);
  EXPECT_EQ(along.judge(watched(0.9, 0.9, 0.06, 0.05)).sliding, Sliding::translation);
}

TEST(GraspTracker, SaysWhatItsFingersSayOfSliding) {
  GraspTracker judge({});
  std::array members = watched(0, 0);
  members[0].sliding = members[1].sliding = Sliding::none;
  members[0].published_ns = kMillisecond;
  EXPECT_EQ(judge.judge(members).sliding, Sliding::none);
  members[0].published_ns = 5 * kMillisecond;
  EXPECT_NEAR(judge.judge(members).sliding_for_s.value(), 0.004, 1e-9);
  members[1].sliding = Sliding::rotation;
  members[1].pattern.reset();
  EXPECT_EQ(judge.judge(members).sliding, Sliding::rotation) << "one that is sure is enough";
  members[1].sliding.reset();
  EXPECT_FALSE(judge.judge(members).sliding) << "one cannot tell";
}

TEST(GraspTracker, ForeseesTheSlipOfAMarginThatFalls) {
  GraspTracker judge({});
  for (int i = 0; i < 50; ++i) judge.judge(at(i * kMillisecond, 0.9 - 0.01 * i));
  EXPECT_NEAR(judge.judge(at(50 * kMillisecond, 0.4)).time_to_slip_s.value(), 0.04, 1e-3);
}

}  // namespace
}  // namespace slipd
