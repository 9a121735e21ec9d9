// What the decision makes of what stages say.
#include "core/margin/margin_decision.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"

namespace slipd {
namespace {

constexpr double kMostSigma = 0.15;

MarginDecision decision_of(MeanSigma margin) {
  MarginDecision decision(kMostSigma);
  decision.propose(margin);
  return decision;
}

Estimate applied(const MarginDecision& decision) {
  Estimate out;
  decision.apply(out);
  EXPECT_EQ(out.gamma.has_value(), out.state == State::ok);
  EXPECT_EQ(out.sigma.has_value(), out.state == State::ok);
  return out;
}

TEST(MarginDecision, WithoutAProposalThereIsNoMargin) {
  MarginDecision decision(kMostSigma);
  EXPECT_EQ(applied(decision).state, State::learning);
  EXPECT_FALSE(applied(decision).gamma_low);
}

TEST(MarginDecision, AProposalThatStandsIsTheMargin) {
  const Estimate out = applied(decision_of({0.4, 0.03}));
  EXPECT_EQ(out.state, State::ok);
  EXPECT_EQ(out.gamma, 0.4);
  EXPECT_NEAR(out.sigma.value(), std::hypot(0.03, kExactShare), 1e-12);
}

TEST(MarginDecision, WhatWidensAMarginBeyondTheLargestSigmaTakesItAway) {
  MarginDecision decision = decision_of({0.4, 0.1});
  decision.widen(0.05);
  decision.widen(0.05);
  EXPECT_NEAR(applied(decision).sigma.value(), std::sqrt(0.1 * 0.1 + 2 * 0.05 * 0.05), 1e-5);
  decision.widen(0.1);
  EXPECT_EQ(applied(decision).state, State::learning);
}

TEST(MarginDecision, TheFirstReasonToRefuseStandsAndAFaultIsStronger) {
  MarginDecision decision(kMostSigma);
  decision.refuse(State::out_of_model);
  decision.propose({0.4, 1});
  decision.refuse(State::no_contact);
  EXPECT_EQ(applied(decision).state, State::out_of_model);
  decision.fail();
  EXPECT_EQ(applied(decision).state, State::fault);
  MarginDecision never(kMostSigma, kExactShare, State::no_shear);
  never.refuse(State::no_contact);
  EXPECT_EQ(applied(never).state, State::no_shear);
}

TEST(MarginDecision, TheLowEndIsBelowTheBoundAndBelowTheMarginsOwn) {
  for (const auto& [margin, bound, low] :
       {std::tuple(0.9, 0.5, 0.5), std::tuple(0.6, 0.9, 0.6 - kOneSided95 * 0.1),
        std::tuple(0.1, 0.9, 0.0)}) {
    MarginDecision decision = decision_of({margin, 0.1});
    decision.bound(bound);
    EXPECT_NEAR(applied(decision).gamma_low.value(), low, 1e-5);
  }
  MarginDecision unknown(kMostSigma);
  unknown.refuse(State::learning);
  unknown.bound(0.5);
  EXPECT_EQ(applied(unknown).gamma_low, 0.5) << "it needs no margin";
}

TEST(MarginDecision, WhatNeighboursStandForLowersTheLowEndAndWidensTheMargin) {
  MarginDecision decision = decision_of({0.9, 0.01});
  decision.bound(0.8);
  decision.leave_out(0.1);
  EXPECT_NEAR(applied(decision).sigma.value(), std::hypot(0.01, 0.1), 1e-5);
  EXPECT_NEAR(applied(decision).gamma_low.value(), 0.8 - kOneSided95 * 0.1, 1e-12);
}

TEST(MarginDecision, AnObjectThatSlidesHasNoSafeMargin) {
  for (const double margin : {0.8, 0.1}) {
    MarginDecision decision = decision_of({margin, 0.02});
    decision.bound(0.7);
    decision.slide(0.2);
    const Estimate out = applied(decision);
    EXPECT_EQ(out.gamma_low, 0);
    EXPECT_EQ(out.state, margin > 0.2 ? State::out_of_model : State::ok) << margin;
  }
}

TEST(MarginDecision, AMarginThatMayBeNoneLeavesOpenWhetherTheObjectSlides) {
  for (const auto& [margin, sigma, open] :
       {std::tuple(0.0, 0.0, true), std::tuple(0.02, 0.03, true), std::tuple(0.3, 0.03, false)}) {
    const MarginDecision decision = decision_of({margin, sigma});
    Estimate held;
    held.sliding = Sliding::none;
    held.sliding_for_s = 0.8;
    decision.apply(held);
    EXPECT_EQ(held.sliding.has_value(), !open) << margin;
    EXPECT_EQ(held.sliding_for_s.has_value(), !open) << margin;
    held.sliding = Sliding::translation;
    decision.apply(held);
    EXPECT_EQ(held.sliding, Sliding::translation) << "what is seen is said";
  }
}

}  // namespace
}  // namespace slipd
