#include "core/contact/dome.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/contact/averages.hpp"
#include "core/contact/dome_sheet.hpp"

namespace slipd::contact {
namespace {

TEST(Dome, ItsArcTangentIsTheLibrarysToFourteenDigits) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 100000; ++i) {
    const double y = unit(random) * std::pow(10.0, 8 * unit(random)), x = std::fabs(unit(random));
    EXPECT_NEAR(angle_from_height(y, x), std::atan2(y, x), 4e-15);
  }
  EXPECT_EQ(angle_from_height(0, 0), 0);
  EXPECT_DOUBLE_EQ(angle_from_height(-1, 0), -std::numbers::pi / 2);
}

TEST(Dome, ItsDerivativesAreThoseOfItsAverage) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(-1.2, 1.2);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 20000; ++i) {
    const double u = unit(random), v = unit(random), side = 0.02 + 0.2 * std::fabs(unit(random));
    const auto average = [&](double x, double du, double dv) {
      return disc_average_exact(x, u + du, v + dv, side);
    };
    const DomeAverage got = dome_average(1, u, v, side);
    EXPECT_NEAR(got.value, average(1, 0, 0), 1e-11);
    // Central differences of values with an error of 1e-12 have an error of a few 1e-6 at the rim.
    EXPECT_NEAR(got.d_x, (average(1 + kStep, 0, 0) - average(1 - kStep, 0, 0)) / (2 * kStep), 2e-5);
    EXPECT_NEAR(got.d_u, (average(1, kStep, 0) - average(1, -kStep, 0)) / (2 * kStep), 2e-5);
    EXPECT_NEAR(got.d_v, (average(1, 0, kStep) - average(1, 0, -kStep)) / (2 * kStep), 2e-5);
  }
}

TEST(DomeSheet, AgreesWithTheClosedFormFromFineGridsToATaxelLargerThanTheContact) {
  for (const double side : {0.03, 0.1, 0.3, 0.9, 3.0}) {
    std::vector<double> u, v;
    for (double y = -1.5; y <= 1.5; y += side) {
      for (double x = -1.5; x <= 1.5; x += side) {
        u.push_back(x + 0.013);
        v.push_back(y - 0.007);
      }
    }
    std::vector<double> value(u.size()), d_x(u.size()), d_u(u.size()), d_v(u.size());
    DomeSheet sheet(u.size(), side);
    for (const double radius : {0.0, 0.01, 0.4, 1.0}) {
      sheet.evaluate(radius, u, v, value, d_x, d_u, d_v);
      for (std::size_t i = 0; i < u.size(); ++i) {
        EXPECT_NEAR(value[i], dome_average(radius, u[i], v[i], side).value, 6e-5 * std::max(radius, 0.01));
        EXPECT_NEAR(d_x[i], dome_average(radius, u[i], v[i], side).d_x, 2e-3);
        EXPECT_NEAR(d_u[i], dome_average(radius, u[i], v[i], side).d_u, 2e-3);
      }
    }
  }
}

}  // namespace
}  // namespace slipd::contact
