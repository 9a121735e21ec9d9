#include "core/friction/foundations/monotonic_contact.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/reading/moments/moments.hpp"

namespace slipd {
namespace {

TEST(MonotonicContact, IsThatOfTheClosedForm) {
  constexpr int kUtilisations = 10'007;
  for (int i = 0; i <= kUtilisations; ++i) {
    const double utilisation = static_cast<double>(i) / kUtilisations, k = std::cbrt(1 - utilisation);
    const MonotonicContact got = monotonic_contact(utilisation);
    ASSERT_NEAR(got.slip_moment, 5.0 / 3 * (1 - std::pow(k, 3)) - (1 - std::pow(k, 5)), 1e-5) << utilisation;
    ASSERT_NEAR(got.gamma_per_moment_ratio, gamma_per_moment_ratio(k), 0.005) << utilisation;
  }
}

TEST(MonotonicContact, BeyondNoLoadAndGrossSlipIsThatOfTheNearerEnd) {
  EXPECT_EQ(monotonic_contact(-1).slip_moment, 0);
  EXPECT_NEAR(monotonic_contact(7).slip_moment, 2.0 / 3, 1e-12);
  EXPECT_EQ(monotonic_contact(7).gamma_per_moment_ratio, monotonic_contact(1).gamma_per_moment_ratio);
}

}  // namespace
}  // namespace slipd
