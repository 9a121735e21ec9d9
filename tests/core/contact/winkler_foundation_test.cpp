#include "tests/core/contact/winkler_foundation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/contact/history.hpp"

namespace slipd::contact {
namespace {

// Shear moments from the disc terms of the exact history: <u> = 2 x^2/5 and <u^2> = 8 x^4/35 of D_x.
ShearMoments shape_of(const LoadHistory& exact) {
  double q = 0, u = 0, u2 = 0;
  for (const auto& term : exact.shear_terms()) {
    const double s = term.radius_m / exact.contact_radius_m(), force = term.coefficient * s * s * s;
    q += force;
    u += force * 0.4 * s * s;
    u2 += force * 8 / 35 * s * s * s * s;
  }
  if (q == 0) return {};
  return {exact.shear_n() * (5.0 / 3 - 2.5 * u / q), exact.shear_n() * (6 * u2 / q - 6 * u / q + 1)};
}

BodyPair rubber_on_steel() {
  return make_body_pair({.radius_m = 0.01, .modulus_pa = 5e5, .poisson = 0.45},
                        {.radius_m = 0.03, .modulus_pa = 2e11, .poisson = 0.25});
}

TEST(WinklerFoundation, FollowsAnyHistoryAsTheExactOneDoes) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int grasp = 0; grasp < 60; ++grasp) {
    LoadHistory exact(rubber_on_steel());
    WinklerFoundation springs;
    const double mu = 0.1 + 0.8 * unit(random);
    double p = 0, q = 0;
    for (int phase = 0; phase < 8; ++phase) {
      const bool only_shear = phase > 0 && unit(random) < 0.4;
      const double p_to = only_shear ? p : 1 + 4 * unit(random);
      const double q_to = phase == 0 ? 0 : mu * p_to * (2 * unit(random) - 1);
      for (int i = 1; i <= 30; ++i) {
        const double f = i / 30.0, p_now = p + f * (p_to - p), q_now = q + f * (q_to - q);
        exact.move_to(p_now, q_now, mu);
        springs.follow(p_now, q_now, mu);
        const auto got = springs.shear_moments(), expected = shape_of(exact);
        ASSERT_NEAR(got.slip_moment_n, expected.slip_moment_n, 0.006 * mu * p_now)
            << "grasp " << grasp << " phase " << phase << " step " << i;
        ASSERT_NEAR(got.second_legendre_n, expected.second_legendre_n, 0.02 * mu * p_now);
        ASSERT_NEAR(springs.shear_n(), exact.shear_n(), 1e-9);
      }
      p = p_to;
      q = exact.shear_n();
    }
  }
}

TEST(WinklerFoundation, AContactThatSticksEverywhereHasTheShearOfItsPressure) {
  WinklerFoundation springs;
  for (int i = 1; i <= 100; ++i) {
    // Q/P = 1/4 at every step: the traction ratio is 1/4 up to the rim, and nothing slips.
    springs.follow(0.02 * i, 0.005 * i, 0.5);
    EXPECT_NEAR(springs.shear_moments().slip_moment_n, (5.0 / 3 - 1) * 0.005 * i, 0.002 * 0.02 * i);
  }
  const double grown = springs.shear_moments().slip_moment_n;
  springs.follow(2, 0.55, 0.5);
  EXPECT_NEAR(springs.shear_moments().slip_moment_n, grown, 0.01)
      << "a small load that sticks changes nothing";
}

TEST(WinklerFoundation, AnAssumedMonotonicLoadEqualsAFollowedOne) {
  WinklerFoundation assumed, risen;
  assumed.assume_monotonic(3, 1, 0.6);
  risen.follow(3, 0, 0.6);
  for (int i = 1; i <= 50; ++i) risen.follow(3, 0.02 * i, 0.6);
  EXPECT_NEAR(assumed.shear_moments().slip_moment_n, risen.shear_moments().slip_moment_n, 1e-3);
}

TEST(WinklerFoundation, CarriesNoMoreThanFrictionHolds) {
  WinklerFoundation springs;
  springs.follow(2, 5, 0.5);
  EXPECT_DOUBLE_EQ(springs.shear_n(), 1);
  EXPECT_NEAR(springs.shear_moments().slip_moment_n, 2.0 / 3, 0.01)
      << "gross slip: shear lies as pressure does";
  springs.follow(0, 1, 0.5);
  EXPECT_EQ(springs.shear_n(), 0);
  EXPECT_EQ(springs.shear_moments().slip_moment_n, 0);
}

}  // namespace
}  // namespace slipd::contact
