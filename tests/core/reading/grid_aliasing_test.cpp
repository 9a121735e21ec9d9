// What a grid adds to <r^2> of a contact, against sums over taxels of exact averages.
#include "core/reading/moments/grid_aliasing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/contact/averages.hpp"

namespace slipd {
namespace {

constexpr double kSideM = 0.001;

struct Sums {
  double all = 0, second = 0;
};

// Over all taxels that a dome of this radius reaches, whose middles are (x_m, y_m) from one of theirs.
Sums sums_of(double radius_m, double x_m, double y_m) {
  const int reach = static_cast<int>(radius_m / kSideM) + 3;
  Sums sums;
  for (int i = -reach; i <= reach; ++i) {
    for (int j = -reach; j <= reach; ++j) {
      const double u_m = i * kSideM - x_m, v_m = j * kSideM - y_m;
      const double value = contact::disc_average_exact(radius_m, u_m, v_m, kSideM);
      sums.all += value;
      sums.second += value * (u_m * u_m + v_m * v_m);
    }
  }
  return sums;
}

TEST(GridAliasing, IsWhatTaxelsAddToTheSecondMomentOfALoadThatOnlyRose) {
  double worst = 0, worst_left = 0;
  for (const double radius_m : {0.002, 0.0031, 0.0047}) {
    for (const double gamma : {0.2, 0.5, 0.7, 0.9}) {
      const double stick_m = radius_m * std::cbrt(gamma);
      for (int place = 0; place < 12; ++place) {
        const double x_m = kSideM * std::fmod(0.37 * place, 1), y_m = kSideM * std::fmod(0.61 * place, 1);
        const Sums whole = sums_of(radius_m, x_m, y_m), sticks = sums_of(stick_m, x_m, y_m);
        // <r^2> of the difference of two domes: of each it is 2/5 of its squared radius.
        const double fifth = std::pow(gamma, 5.0 / 3);
        const double true_m2 = 0.4 * radius_m * radius_m * (1 - fifth) / (1 - gamma);
        const double added_m2 =
            (whole.second - sticks.second) / (whole.all - sticks.all) - kSideM * kSideM / 6 - true_m2;
        const double left_m2 = added_m2 - GridAliasing(kSideM, x_m, y_m).of_shear_m2(radius_m, gamma);
        worst = std::max(worst, std::fabs(added_m2) / true_m2);
        worst_left = std::max(worst_left, std::fabs(left_m2) / true_m2);
      }
    }
  }
  EXPECT_GT(worst, 0.05);
  EXPECT_LT(worst_left, 0.1 * worst);  // what harmonics above the second leave
}

TEST(GridAliasing, WithoutALoadItIsThatOfTheLastRing) {
  const GridAliasing aliasing(kSideM, 0.0002, 0.0004);
  const double none = aliasing.of_shear_m2(0.003, 1);
  EXPECT_TRUE(std::isfinite(none));
  EXPECT_NEAR(none, aliasing.of_shear_m2(0.003, 0.998), 0.05 * kSideM * kSideM);
}

}  // namespace
}  // namespace slipd
