// Fingers together: the grasp's margin is that of all they carry against all they could.
#include "core/estimate/grasp.hpp"

#include <gtest/gtest.h>

#include <array>

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
  EXPECT_DOUBLE_EQ(grasp_margin(members, {}).gamma.value(), 0.5);
}

TEST(Grasp, TheMarginIsOneMinusSumOfShearOverSumOfLimits) {
  const std::array members{finger(2, 0.3, 0.5), finger(4, -0.5, 0.25)};
  const auto margin = grasp_margin(members, {});
  EXPECT_EQ(margin.state, State::ok);
  EXPECT_DOUBLE_EQ(margin.gamma.value(), 1 - 0.8 / 2.0);
  EXPECT_DOUBLE_EQ(margin.friction.value(), 2.0 / 6);
}

TEST(Grasp, TheAdviceReachesTheTargetExactly) {
  const AlertSettings alerts{.target_margin = 0.6};
  const std::array members{finger(2, 0.7, 0.5), finger(2, 0.7, 0.5)};
  const double more = grasp_margin(members, alerts).grip_increase_n.value();
  EXPECT_GT(more, 0);
  const std::array tighter{finger(2 + more / 2, 0.7, 0.5), finger(2 + more / 2, 0.7, 0.5)};
  EXPECT_NEAR(grasp_margin(tighter, alerts).gamma.value(), 0.6, 1e-12);
  EXPECT_NEAR(grasp_margin(tighter, alerts).grip_increase_n.value(), 0, 1e-12);
}

TEST(Grasp, AFingerInTheAirCarriesNothing) {
  const std::array members{finger(2, 0.5, 0.5), in_state(State::no_contact)};
  EXPECT_DOUBLE_EQ(grasp_margin(members, {}).gamma.value(), 0.5);
  const std::array air{in_state(State::no_contact), in_state(State::no_contact)};
  EXPECT_EQ(grasp_margin(air, {}).state, State::no_contact);
  EXPECT_FALSE(grasp_margin(air, {}).gamma);
}

TEST(Grasp, WithOneFingerUnknownTheWholeIsUnknown) {
  for (const State state :
       {State::learning, State::out_of_model, State::no_shear, State::unzeroed, State::stale, State::fault}) {
    const std::array members{finger(2, 0.5, 0.5), in_state(state)};
    EXPECT_EQ(grasp_margin(members, {}).state, state);
    EXPECT_FALSE(grasp_margin(members, {}).gamma);
  }
  Estimate blind = finger(2, 0.5, 0.5);
  blind.friction.reset();
  const std::array members{finger(2, 0.5, 0.5), blind};
  EXPECT_EQ(grasp_margin(members, {}).state, State::learning);
  EXPECT_FALSE(grasp_margin({}, {}).gamma);
}

TEST(Grasp, AlertsGoByTheThresholds) {
  const AlertSettings alerts;
  const auto alert_at = [&](double gamma) {
    const std::array members{finger(2, (1 - gamma) * 0.5 * 2, 0.5)};
    return grasp_margin(members, alerts).alert;
  };
  EXPECT_EQ(alert_at(0.9), Alert::none);
  EXPECT_EQ(alert_at(0.3), Alert::warn);
  EXPECT_EQ(alert_at(0.1), Alert::slip);
  EXPECT_EQ(alert_at(-0.1), Alert::slip) << "more shear than the limit counts as none left";
}

}  // namespace
}  // namespace slipd
