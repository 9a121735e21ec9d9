#include "core/contact/subsurface/dome.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "core/contact/averages.hpp"
#include "core/contact/subsurface/dome_averages.hpp"
#include "core/contact/subsurface/dome_lattice.hpp"

namespace slipd::contact {
namespace {

TEST(Dome, ItsArcTangentIsTheLibrarysToFourteenDigits) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 100000; ++i) {
    const double y = unit(random) * std::pow(10.0, 8 * unit(random)), x = std::fabs(unit(random));
    EXPECT_NEAR(angle_from_height(y, x), std::atan2(y, x), 4e-15);
    EXPECT_NEAR(angle_from_height(static_cast<float>(y), static_cast<float>(x)), std::atan2(y, x), 3e-7);
  }
  EXPECT_EQ(angle_from_height(0.0, 0.0), 0);
  EXPECT_DOUBLE_EQ(angle_from_height(-1.0, 0.0), -std::numbers::pi / 2);
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

TEST(DomeAverages, AreTheClosedFormFromFineGridsToATaxelLargerThanTheContact) {
  for (const double side : {0.03, 0.1, 0.3, 0.9, 3.0}) {
    std::vector<double> u, v;
    for (double y = -1.5; y <= 1.5; y += side) {
      for (double x = -1.5; x <= 1.5; x += side) {
        u.push_back(x + 0.013);
        v.push_back(y - 0.007);
      }
    }
    std::vector<double> value(u.size()), d_x(u.size()), d_u(u.size()), d_v(u.size()), alone(u.size());
    for (const double radius : {0.0, 0.01, 0.4, 1.0}) {
      average_dome(radius, side, u, v, {value, d_x, d_u, d_v});
      average_dome(radius, side, u, v, alone);
      for (std::size_t i = 0; i < u.size(); ++i) {
        // Rounding of corners, over the square's area.
        const double least = 1e-15 / (side * side);
        EXPECT_NEAR(value[i], disc_average_exact(radius, u[i], v[i], side), least);
        EXPECT_NEAR(alone[i], value[i], least);
        const DomeAverage mean = dome_average(radius, u[i], v[i], side);
        EXPECT_NEAR(d_x[i], mean.d_x, 1e-11);
        EXPECT_NEAR(d_u[i], mean.d_u, 1e-11);
        EXPECT_NEAR(d_v[i], mean.d_v, 1e-11);
      }
    }
  }
}

// Runs of any length, none as well, in any columns.
std::vector<TaxelRun> random_rows(std::mt19937_64& random, std::size_t most) {
  std::vector<TaxelRun> rows(1 + random() % most);
  for (TaxelRun& run : rows) {
    run.first = static_cast<std::uint32_t>(random() % most);
    run.end = run.first + static_cast<std::uint32_t>(random() % (most - run.first + 1));
  }
  return rows;
}

TEST(DomeLattice, AgreesWithTheClosedFormOfEachSquare) {
  constexpr std::size_t kMost = 12;
  DomeLattice lattice(kMost);
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 200; ++i) {
    const std::vector<TaxelRun> rows = random_rows(random, kMost);
    const double side = 0.05 + 0.3 * unit(random), left = -1.5 * unit(random), bottom = -1.5 * unit(random);
    const double x = unit(random), center_x = 0.3 * unit(random), center_y = -0.2 * unit(random);
    lattice.set({.left_m = left, .bottom_m = bottom, .side_m = side, .rows = rows});
    std::vector<double> value(kMost * kMost), d_x(value), d_u(value), d_v(value);
    lattice.evaluate(x, center_x, center_y, {value, d_x, d_u, d_v});
    std::size_t at = 0;
    for (std::size_t row = 0; row < rows.size(); ++row) {
      for (std::uint32_t column = rows[row].first; column < rows[row].end; ++column, ++at) {
        const DomeAverage mean =
            dome_average(x, left + side * (column + 0.5) - center_x,
                         bottom + side * (static_cast<double>(row) + 0.5) - center_y, side);
        EXPECT_NEAR(value[at], mean.value, 1e-12) << "rounding of corners, over the square's area";
        EXPECT_NEAR(d_x[at], mean.d_x, 1e-11);
        EXPECT_NEAR(d_u[at], mean.d_u, 1e-11);
        EXPECT_NEAR(d_v[at], mean.d_v, 1e-11);
      }
    }
  }
}

TEST(DomeLattice, SumsTheRingsThatDomesOfAllRadiiLeaveAsEachByItselfDoes) {
  constexpr std::size_t kMost = 9;
  DomeLattice lattice(kMost);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 200; ++i) {
    const std::vector<TaxelRun> rows = random_rows(random, kMost);
    std::size_t count = 0;
    for (const TaxelRun& run : rows) count += run.end - run.first;
    const double side = 0.1 + 0.5 * unit(random), left = -1.5 * unit(random), bottom = -1.5 * unit(random);
    const double x = 0.2 + unit(random), center_x = 0.3 * unit(random), center_y = -0.2 * unit(random);
    lattice.set({.left_m = left, .bottom_m = bottom, .side_m = side, .rows = rows});
    std::vector<double> whole(kMost * kMost), d_x(whole), d_u(whole), d_v(whole), dome(whole), field;
    lattice.evaluate(x, center_x, center_y, {whole, d_x, d_u, d_v});
    for (std::size_t at = 0; at < count; ++at) field.push_back(2 * unit(random) - 1);
    PerRing radii;
    for (std::size_t k = 0; k < kRings; ++k)
      radii[k] = static_cast<float>(x * static_cast<double>(k) / (kRings - 1));
    const RingSums sums = lattice.ring_sums(radii, center_x, center_y, std::span(whole).first(count), field);
    const double off = 1e-6 * x * x * x / (side * side);  // of an average
    for (std::size_t k = 0; k < kRings; ++k) {
      lattice.evaluate(static_cast<double>(radii[k]), center_x, center_y, {dome, d_x, d_u, d_v});
      double squares = 0, product = 0, most = 0, most_field = 0;
      for (std::size_t at = 0; at < count; ++at) {
        const double ring = whole[at] - dome[at];
        squares += ring * ring;
        product += ring * field[at];
        most += 2 * std::fabs(ring) + off;
        most_field += std::fabs(field[at]);
      }
      EXPECT_NEAR(sums.squares[k], squares, off * most + 1e-15) << "ring " << k;
      EXPECT_NEAR(sums.products[k], product, off * most_field + 1e-15) << "ring " << k;
    }
  }
}

}  // namespace
}  // namespace slipd::contact
