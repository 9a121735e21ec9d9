#include "core/contact/averages.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace slipd::contact {
namespace {

const BodyPair kPressedPair =
    make_body_pair({0.01, 0.5e6, 0.45}, {std::numeric_limits<double>::infinity(), 2e11, 0.25});

// The average by brute force: exact in one direction (the area of a circular segment), many lines in the
// other.
double by_lines(double radius, double u, double v, double side) {
  constexpr int kLines = 20000;
  const auto area = [](double half_width,
                       double y) {  // of the half disc x^2 + z^2 < half_width^2, z > 0, up to x = y
    const double c = std::clamp(y, -half_width, half_width);
    return 0.5 * (c * std::sqrt(std::max(0.0, half_width * half_width - c * c)) +
                  half_width * half_width * std::asin(c / half_width));
  };
  double sum = 0;
  for (int i = 0; i < kLines; ++i) {
    const double x = u + side * ((i + 0.5) / kLines - 0.5);
    if (std::fabs(x) >= radius) continue;
    const double half_width = std::sqrt(radius * radius - x * x);
    sum += area(half_width, v + side / 2) - area(half_width, v - side / 2);
  }
  return sum / kLines / side;
}

TEST(TaxelAverages, TheClosedFormIsTheIntegralInsideOutsideAndAcrossTheRim) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const double side = std::pow(10.0, unit(random)), u = 1.5 * unit(random), v = 1.5 * unit(random);
    EXPECT_NEAR(disc_average_exact(1, u, v, side), by_lines(1, u, v, side), 2e-6)
        << u << " " << v << " " << side;
  }
}

TEST(TaxelAverages, TheFastFormIsTheClosedFormToAFloatsResolution) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 20000; ++i) {
    const double side = std::pow(10.0, -2 + 1.5 * (unit(random) + 1) / 2);
    const double u = 1.2 * unit(random), v = 1.2 * unit(random);
    EXPECT_NEAR(disc_average(1, u, v, side), disc_average_exact(1, u, v, side), 6e-8)
        << u << " " << v << " " << side;
  }
}

TEST(TaxelAverages, ReturnTheForcesOnAnyGridThatHoldsTheContact) {
  LoadHistory contact(kPressedPair);
  contact.move_to(2, 0.7, 0.5);
  contact.move_to(3, 0.7, 0.5);
  contact.move_to(3, 0.3, 0.5);
  for (const std::size_t n : {4U, 7U, 16U, 100U}) {
    const auto layout = TaxelLayout::grid(n, n, 0.016 / static_cast<double>(n));
    std::vector<float> p(layout.size()), q(layout.size());
    taxel_averages(layout, 0.0013, -0.0007, contact, p, q);
    double normal = 0, shear = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      normal += p[i] * layout.area_m2();
      shear += q[i] * layout.area_m2();
    }
    EXPECT_NEAR(normal, 3, 1e-6);
    EXPECT_NEAR(shear, 0.3, 1e-6);
  }
}

}  // namespace
}  // namespace slipd::contact
