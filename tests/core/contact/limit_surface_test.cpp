// The limit surface against closed forms for discs, against plain searches over the instantaneous centre, and
// against the bounds that no load may pass.
#include "core/contact/limit_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace slipd::contact {
namespace {

struct PlainCell {
  double x = 0, y = 0, normal = 0;
};

// A pressure over [-1, 1] x [-1, 1], its total 1. `pressure` is averaged over kSub x kSub points of a cell.
std::vector<PlainCell> cells_of(int across, const std::function<double(double, double)>& pressure) {
  constexpr int kSub = 16;
  std::vector<PlainCell> cells;
  double total = 0;
  const double side = 2.0 / across;
  for (int row = 0; row < across; ++row) {
    for (int column = 0; column < across; ++column) {
      PlainCell cell;
      for (int k = 0; k < kSub * kSub; ++k) {
        const double x = (column + (k % kSub + 0.5) / kSub) * side - 1;
        const double y = (row + (k / kSub + 0.5) / kSub) * side - 1, p = pressure(x, y);
        cell.normal += p;
        cell.x += p * x;
        cell.y += p * y;
      }
      if (cell.normal == 0) continue;
      cell.x /= cell.normal;
      cell.y /= cell.normal;
      total += cell.normal;
      cells.push_back(cell);
    }
  }
  for (PlainCell& cell : cells) cell.normal /= total;
  return cells;
}

LimitSurface surface_of(const std::vector<PlainCell>& cells, double side, double x = 0, double y = 0) {
  LimitSurface surface;
  surface.clear(side);
  for (const PlainCell& cell : cells) surface.add(cell.x - x, cell.y - y, cell.normal);
  return surface;
}

double hertz(double x, double y) {
  return std::sqrt(std::max(0.0, 1 - x * x - y * y));
}
double even(double x, double y) {
  return x * x + y * y < 1 ? 1 : 0;
}
double tilted_ellipse(double x, double y) {
  const double rest = 1 - x * x - 2.5 * y * y;
  return rest > 0 ? std::sqrt(rest) * (1 + 0.4 * x - 0.2 * y) : 0;
}

TEST(LimitSurface, APullAloneAsksForItsShareOfTheNormalForce) {
  const auto cells = cells_of(14, tilted_ellipse);
  double x = 0, y = 0;
  for (const PlainCell& cell : cells) {
    x += cell.normal * cell.x;
    y += cell.normal * cell.y;
  }
  const LimitSurface surface = surface_of(cells, 2.0 / 14, x, y);
  for (const double toward : {0.0, 0.7, 2.0, 4.0}) {
    const LeastFriction least = surface.least_friction(0.3 * std::cos(toward), 0.3 * std::sin(toward), 0);
    EXPECT_NEAR(least.ratio, 0.3, 1e-6);
    EXPECT_NEAR(least.per_shear_n, 1, 1e-5);
    EXPECT_NEAR(least.per_torque_nm, 0, 1e-3);
  }
}

// T_max = mu P times the mean distance from the centre: 3 pi/16 a for Hertz, 2/3 a for an even pressure.
TEST(LimitSurface, ATorqueAloneIsHeldByTheMeanLever) {
  EXPECT_NEAR(1 / surface_of(cells_of(12, hertz), 2.0 / 12).least_friction(0, 0, 1).ratio,
              3 * std::numbers::pi / 16, 5e-4);
  EXPECT_NEAR(1 / surface_of(cells_of(12, even), 2.0 / 12).least_friction(0, 0, 1).ratio, 2.0 / 3, 1e-3);
  EXPECT_NEAR(1 / unit_hertz_surface().least_friction(0, 0, -1).ratio, 3 * std::numbers::pi / 16, 5e-4);
}

// A rigid flat punch has p ~ 1/sqrt(1 - r^2), and T_max = pi/4 mu P a.
TEST(LimitSurface, HoldsAPunchByItsRim) {
  LimitSurface surface;
  constexpr int kRings = 42, kSpokes = 6;
  surface.clear(1e-6);
  for (int ring = 0; ring < kRings; ++ring) {
    // Rings of equal force; P within s is 1 - sqrt(1 - s^2).
    const double share = (ring + 0.5) / kRings, s = std::sqrt(1 - (1 - share) * (1 - share));
    for (int spoke = 0; spoke < kSpokes; ++spoke) {
      const double toward = 2 * std::numbers::pi * spoke / kSpokes;
      surface.add(s * std::cos(toward), s * std::sin(toward), 1.0 / (kRings * kSpokes));
    }
  }
  EXPECT_NEAR(1 / surface.least_friction(0, 0, 1).ratio, std::numbers::pi / 4, 2e-3);
}

// Gamma of a 4 mm Hertz contact as an independent solver and search give it, to the digits that they print.
TEST(LimitSurface, AgreesWithAnIndependentSearchUnderForceAndTorque) {
  const LimitSurface surface = unit_hertz_surface();
  EXPECT_NEAR(1 - surface.least_friction(0.170, 0, 0.236).ratio, 0.552, 2e-3);
  EXPECT_NEAR(1 - surface.least_friction(0.336, 0, 0.213).ratio, 0.476, 2e-3);
  EXPECT_NEAR(1 - surface.least_friction(0, 0.152, -0.386).ratio, 0.320, 2e-3);
}

// What a load asks of friction if the object turns about one centre.
double asked(const std::vector<PlainCell>& cells, double x, double y, double torque, double at_x,
             double at_y) {
  double held = 0;
  for (const PlainCell& cell : cells) held += cell.normal * std::hypot(cell.x - at_x, cell.y - at_y);
  return std::fabs(torque - (at_x * y - at_y * x)) / held;
}

// The largest factor is the least of all bounds: here those of centres all over the plane, and then of ever
// nearer ones about the best. Fine cells, as points.
double asked_at_most(const std::vector<PlainCell>& cells, double x, double y, double torque) {
  constexpr int kReach = 12, kRounds = 14;
  double u = 0, v = 0, step = 1.5 / kReach, most = 0;  // tan(u) reaches all the plane
  for (int round = 0; round < kRounds; ++round) {
    const double from_u = u, from_v = v;
    const int reach = round == 0 ? kReach : 2;
    for (int row = -reach; row <= reach; ++row) {
      for (int column = -reach; column <= reach; ++column) {
        const double at_u = from_u + column * step, at_v = from_v + row * step;
        const double now = asked(cells, x, y, torque, std::tan(at_u), std::tan(at_v));
        if (now > most) {
          most = now;
          u = at_u;
          v = at_v;
        }
      }
    }
    step /= 2;
  }
  return std::max(most, std::hypot(x, y));
}

TEST(LimitSurface, IsTheLeastBoundOverAllRigidVelocities) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto fine = cells_of(60, tilted_ellipse);
  const LimitSurface surface = surface_of(cells_of(12, tilted_ellipse), 2.0 / 12);
  for (int i = 0; i < 12; ++i) {
    const double x = unit(random), y = unit(random), torque = unit(random);
    const double most = asked_at_most(fine, x, y, torque), ratio = surface.least_friction(x, y, torque).ratio;
    EXPECT_NEAR(ratio / most, 1, 2e-3) << x << ' ' << y << ' ' << torque;
  }
}

TEST(LimitSurface, DoesNotDependOnThePointThatTorqueIsTakenAbout) {
  const auto cells = cells_of(12, tilted_ellipse);
  const double ratio = surface_of(cells, 2.0 / 12).least_friction(0.2, -0.1, 0.15).ratio;
  const double x = 0.3, y = -0.2;
  const double moved =
      surface_of(cells, 2.0 / 12, x, y).least_friction(0.2, -0.1, 0.15 - (x * -0.1 - y * 0.2)).ratio;
  EXPECT_NEAR(moved, ratio, 1e-5);
}

TEST(LimitSurface, TurnsEitherWayAlikeAndGrowsWithTorque) {
  const LimitSurface surface = unit_hertz_surface();
  double last = 0.2;
  for (double torque = 0.02; torque < 0.6; torque += 0.02) {
    const double ratio = surface.least_friction(0.2, 0, torque).ratio;
    EXPECT_GT(ratio, last);
    EXPECT_NEAR(surface.least_friction(0.2, 0, -torque).ratio, ratio, 1e-5);
    // The ellipsoid overstates what is carried, by up to 6 %.
    const double ellipsoid = std::hypot(0.2, torque * 16 / (3 * std::numbers::pi));
    EXPECT_GE(ratio, ellipsoid * (1 - 1e-3));
    EXPECT_LE(ratio, ellipsoid * 1.07);
    last = ratio;
  }
}

TEST(LimitSurface, ItsSlopesAreThoseOfTheRatio) {
  const LimitSurface surface = unit_hertz_surface();
  constexpr double kStep = 0.01;
  for (const double torque : {0.05, 0.2, -0.3}) {
    const LeastFriction at = surface.least_friction(0.25, 0, torque);
    const double by_shear = (surface.least_friction(0.25 + kStep, 0, torque).ratio -
                             surface.least_friction(0.25 - kStep, 0, torque).ratio) /
                            (2 * kStep);
    const double more = torque > 0 ? kStep : -kStep;
    const double by_torque = (surface.least_friction(0.25, 0, torque + more).ratio -
                              surface.least_friction(0.25, 0, torque - more).ratio) /
                             (2 * kStep);
    EXPECT_NEAR(at.per_shear_n, by_shear, 2e-3);
    EXPECT_NEAR(at.per_torque_nm, by_torque, 1e-2);
  }
}

TEST(LimitSurface, HasNoAnswerWithoutPressureOrLoad) {
  LimitSurface surface;
  surface.clear(0.1);
  EXPECT_EQ(surface.least_friction(1, 0, 1).ratio, 0);
  surface.add(0, 0, -1);
  EXPECT_EQ(surface.least_friction(1, 0, 1).ratio, 0);
  EXPECT_EQ(unit_hertz_surface().least_friction(0, 0, 0).ratio, 0);
}

TEST(LimitSurface, HoldsALineAndASinglePoint) {
  LimitSurface line;
  line.clear(1e-3);
  for (int i = -3; i <= 3; ++i) line.add(0.1 * i, 0, 1);
  // The sum of the seven levers.
  EXPECT_NEAR(1 / line.least_friction(0, 0, 1).ratio, 1.2, 1e-3);
  LimitSurface point;
  point.clear(0.1);
  point.add(0, 0, 2);
  EXPECT_NEAR(point.least_friction(1, 0, 0).ratio, 0.5, 1e-6);
  EXPECT_TRUE(std::isfinite(point.least_friction(1, 0, 0.01).ratio));
  EXPECT_GT(point.least_friction(0, 0, 0.1).ratio, 1);
}

// From a torque that vanishes to a force that does.
TEST(LimitSurface, GoesOverIntoForceAndTorqueAlone) {
  const LimitSurface hertz = unit_hertz_surface();
  const double torque_alone = hertz.least_friction(0, 0, 1).ratio;
  EXPECT_NEAR(torque_alone, 16 / (3 * std::numbers::pi), 0.01);
  for (double small = 0.05; small > 1e-13; small /= 10) {
    const LeastFriction light = hertz.least_friction(1, 0, small), slow = hertz.least_friction(small, 0, 1);
    EXPECT_NEAR(light.ratio, 1 + 2.5 * small * small, 20 * std::pow(small, 4) + 1e-3 * small + 2e-6) << small;
    EXPECT_NEAR(slow.ratio, torque_alone, 2 * small * small + 1e-4) << small;
    for (const LeastFriction& at : {light, slow})
      EXPECT_TRUE(std::isfinite(at.per_shear_n) && std::isfinite(at.per_torque_nm));
    // The unit of forces does not count: friction that vanishes, and loads that do.
    const LeastFriction tiny = hertz.least_friction(1e-9 * small, 0, 0.3e-9 * small);
    EXPECT_NEAR(tiny.ratio / (1e-9 * small), hertz.least_friction(1, 0, 0.3).ratio, 1e-4);
  }
}

// Taxels in a line turn about any point of it; one taxel holds what turns within it.
TEST(LimitSurface, OfTaxelsInALineOrOneAloneIsFinite) {
  LimitSurface line;
  line.clear(1e-3);
  for (int i = -4; i <= 4; ++i) line.add(1e-3 * i, 0, 1);
  const double torque_nm = line.least_friction(0, 0, 1).ratio;
  EXPECT_NEAR(1 / torque_nm, 20e-3, 1.5e-3);  // the sum of |x|, and a little within taxels
  EXPECT_NEAR(line.least_friction(0, 3, 0).ratio, 3.0 / 9, 1e-3);
  LimitSurface one;
  one.clear(1e-3);
  one.add(0, 0, 2);
  EXPECT_NEAR(one.least_friction(1, 0, 0).ratio, 0.5, 1e-6);
  EXPECT_TRUE(std::isfinite(one.least_friction(0, 0, 1).ratio));
  EXPECT_GT(one.least_friction(0, 0, 1).ratio, 0);
}

}  // namespace
}  // namespace slipd::contact
