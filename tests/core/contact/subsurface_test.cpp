#include "core/contact/subsurface/subsurface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "core/contact/averages.hpp"
#include "core/contact/contact_field.hpp"

namespace slipd::contact {
namespace {

using Sheet = SubsurfaceSheet;
constexpr std::array kAll{Sheet::nn, Sheet::nx, Sheet::ny, Sheet::xx, Sheet::xy, Sheet::yy};

std::array<double, 6> list_of(const SensedTensor& t) {
  return {t.nn, t.nx, t.ny, t.xx, t.xy, t.yy};
}

// The integral of 3 d R_i R_j/(2 pi |R|^5) times the dome, which a force on the surface is sensed by: Gauss
// in panels of the angle whose sine is the distance from the centre, and even points around.
SensedTensor sensed_by_quadrature(const Ellipse& dome, double depth, double x, double y) {
  constexpr int kPanels = 16, kAround = 768;
  using Rule = boost::math::quadrature::gauss<double, 20>;
  const double c = std::cos(dome.angle_rad), s = std::sin(dome.angle_rad);
  SensedTensor sum;
  const auto add = [&](double chi, double weight) {
    const double rho = std::sin(chi), height = std::cos(chi);
    for (int j = 0; j < kAround; ++j) {
      const double around = 2 * std::numbers::pi * j / kAround;
      const double u = dome.a_m * rho * std::cos(around), v = dome.b_m * rho * std::sin(around);
      const double rx = x - (c * u - s * v), ry = y - (s * u + c * v);
      const double rr = rx * rx + ry * ry + depth * depth;
      const double w = weight * dome.a_m * dome.b_m * rho * height * height *
                       (2 * std::numbers::pi / kAround) * 3 * depth /
                       (2 * std::numbers::pi * rr * rr * std::sqrt(rr));
      sum.nn += w * depth * depth;
      sum.nx += w * depth * rx;
      sum.ny += w * depth * ry;
      sum.xx += w * rx * rx;
      sum.xy += w * rx * ry;
      sum.yy += w * ry * ry;
    }
  };
  const double width = std::numbers::pi / 2 / kPanels;
  for (int panel = 0; panel < kPanels; ++panel) {
    for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
      for (const double sign : {-1.0, 1.0})
        add(width * (panel + 0.5 + 0.5 * sign * Rule::abscissa()[i]), 0.5 * width * Rule::weights()[i]);
    }
  }
  return sum;
}

TEST(Subsurface, IsTheIntegralOfPointForcesOverRoundAndTiltedEllipticDomes) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 24; ++i) {
    const double a = 1, b = i % 2 == 0 ? 1 : 0.3 + unit(random);
    const Ellipse dome{a, b, 3 * unit(random)};
    const double depth = 0.1 + unit(random), x = 4 * unit(random) - 2, y = 4 * unit(random) - 2;
    const auto sensed = list_of(sensed_of_dome(dome, depth, x, y)),
               truth = list_of(sensed_by_quadrature(dome, depth, x, y));
    for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(sensed[j], truth[j], 1e-10) << i << " " << j;
  }
}

// Huber (1904), for a round contact; on the axis of a pulled one Hamilton (1983).
TEST(Subsurface, AgreesWithTheClosedFormsOfHuberAndHamilton) {
  for (const double z : {0.05, 0.3, 1.0, 3.0}) {
    for (const double r : {0.0, 0.4, 0.99, 1.0, 1.7, 5.0}) {
      const SensedTensor sensed = sensed_of_dome({1, 1, 0}, z, r, 0);
      const double half = 0.5 * (r * r + z * z - 1), u = half + std::sqrt(half * half + z * z);
      EXPECT_NEAR(sensed.nn, std::pow(z / std::sqrt(u), 3) * u / (u * u + z * z), 1e-12);
      EXPECT_NEAR(sensed.nx, r * z * z / (u * u + z * z) * std::sqrt(u) / (1 + u), 1e-12);
      EXPECT_EQ(sensed.ny, 0);
    }
    EXPECT_NEAR(sensed_of_dome({1, 1, 0}, z, 0, 0).xx,
                1 - 1.5 * z * std::atan(1 / z) + 0.5 * z * z / (1 + z * z), 1e-12);
  }
}

TEST(Subsurface, FeelsPressingAsOutwardShearAndAPullAsPressureAhead) {
  const SensedTensor right = sensed_of_dome({4, 3, 0.3}, 1, 3, 0),
                     left = sensed_of_dome({4, 3, 0.3}, 1, -3, 0);
  EXPECT_GT(right.nx, 0.05);
  EXPECT_LT(left.nx, -0.05);
}

TEST(Subsurface, OfAlmostRoundDomesIsThatOfRoundOnes) {
  const auto round = list_of(sensed_of_dome({1, 1, 0}, 0.4, 0.7, -0.5));
  for (const double apart : {1e-3, 1e-5, 1e-9, -1e-7}) {
    const auto sensed = list_of(sensed_of_dome({1 + apart, 1 - apart, 0}, 0.4, 0.7, -0.5));
    for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(sensed[j], round[j], 2 * std::fabs(apart) + 1e-12);
  }
}

// Averages over a fine grid of points.
std::array<double, 6> average(const Ellipse& dome, double depth, double u, double v, double side) {
  const int kFine = depth > 0 ? 60 : 600;
  std::array<double, 6> sum{};
  for (int i = 0; i < kFine; ++i) {
    for (int j = 0; j < kFine; ++j) {
      const auto sensed = list_of(sensed_of_dome(dome, depth, u + side * ((i + 0.5) / kFine - 0.5),
                                                 v + side * ((j + 0.5) / kFine - 0.5)));
      for (std::size_t c = 0; c < 6; ++c) sum[c] += sensed[c] / (kFine * kFine);
    }
  }
  return sum;
}

TEST(SubsurfaceSheets, AverageOverTaxelsToTenThousandthsOfTheHeight) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> unit(0, 1);
  double worst = 0;
  for (const double side : {0.16, 0.5, 1.0, 2.0, 4.7}) {
    for (const double depth : {0.0, 0.25, 0.5, 1.0, 2.0, 3.0}) {
      for (const bool round : {true, false}) {
        const Ellipse dome{5, round ? 5 : 2.7, 0.4};
        std::vector<double> u, v;
        for (int i = 0; i < 12; ++i) {
          const double around = 6.283 * unit(random),
                       r = i % 2 == 0 ? 1 + 0.1 * (unit(random) - 0.5) : unit(random);
          u.push_back(r * dome.a_m * std::cos(around));
          v.push_back(r * dome.b_m * std::sin(around));
        }
        Sheet sheet(u.size(), side, depth);
        sheet.evaluate(dome, u, v);
        for (std::size_t i = 0; i < u.size(); ++i) {
          const auto truth = average(dome, depth, u[i], v[i], side);
          for (std::size_t c = 0; c < 6; ++c) {
            const double error = std::fabs(sheet.row(Sheet::value, kAll[c])[i] - truth[c]);
            worst = std::max(worst, error);
            EXPECT_LT(error, depth > 0 ? 1e-4 : 5e-4 * std::max(1.0, side))
                << side << " " << depth << " " << round << " " << c << " " << sheet.points();
          }
        }
      }
    }
  }
  RecordProperty("worst", std::to_string(worst));
}

// Where the square lies wholly within the dome at depth 0, slopes are smooth; where the rim crosses it, each
// of the lines that it is summed of has a slope that jumps.
bool crosses_rim(const Ellipse& dome, double u, double v, double side) {
  int inside = 0;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5})
      inside += sensed_of_dome(dome, 0, u + side * x, v + side * y).nn > 0 ? 1 : 0;
  }
  return inside > 0 && inside < 4;
}

TEST(SubsurfaceSheets, SlopesAreThoseOfTheValues) {
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const double depth : {0.0, 0.6}) {
    for (const double b : {1.0, 0.9999999, 0.6}) {
      const bool round = b == 1.0 && depth > 0;
      const Ellipse dome{1, b, 0.7};
      std::vector<double> u, v;
      for (int i = 0; i < 40; ++i) {
        u.push_back(1.4 * unit(random));
        v.push_back(1.4 * unit(random));
      }
      Sheet sheet(u.size(), 0.2, depth), plus(u.size(), 0.2, depth), minus(u.size(), 0.2, depth);
      sheet.evaluate(dome, u, v);
      const double step = 1e-5;
      const auto differ = [&](Sheet::Of of, Ellipse by, double du, double dv) {
        std::vector<double> u1 = u, v1 = v, u0 = u, v0 = v;
        for (std::size_t i = 0; i < u.size(); ++i) {
          u1[i] += step * du;
          v1[i] += step * dv;
          u0[i] -= step * du;
          v0[i] -= step * dv;
        }
        plus.evaluate_values(
            {dome.a_m + step * by.a_m, dome.b_m + step * by.b_m, dome.angle_rad + step * by.angle_rad}, u1,
            v1);
        minus.evaluate_values(
            {dome.a_m - step * by.a_m, dome.b_m - step * by.b_m, dome.angle_rad - step * by.angle_rad}, u0,
            v0);
        for (const auto c : kAll) {
          for (std::size_t i = 0; i < u.size(); ++i) {
            const double truth = (plus.row(Sheet::value, c)[i] - minus.row(Sheet::value, c)[i]) / (2 * step);
            // Elliptic domes under a skin: by tables of integrals, of both the value and its slope.
            const double most = depth > 0                            ? (round ? 1e-7 : 2e-6)
                                : crosses_rim(dome, u[i], v[i], 0.2) ? 0.12
                                                                     : 1e-3;
            EXPECT_NEAR(sheet.row(of, c)[i], truth, most)
                << depth << " " << b << " row " << of << " component " << c;
          }
        }
      };
      differ(Sheet::d_u, {0, 0, 0}, 1, 0);
      differ(Sheet::d_v, {0, 0, 0}, 0, 1);
      differ(Sheet::d_a, {1, round ? 1.0 : 0.0, 0}, 0, 0);
      for (auto* deeper : {&plus, &minus}) {
        if (depth > 0) deeper->set_depth(depth * std::exp(deeper == &plus ? step : -step));
      }
      differ(Sheet::d_depth, {0, 0, 0}, 0, 0);
      for (auto* same : {&plus, &minus}) {
        if (depth > 0) same->set_depth(depth);
      }
      if (round) continue;
      differ(Sheet::d_b, {0, 1, 0}, 0, 0);
      differ(Sheet::d_angle, {0, 0, 1}, 0, 0);
    }
  }
}

const BodyPair kSensedPair =
    make_body_pair({0.01, 0.5e6, 0.45}, {std::numeric_limits<double>::infinity(), 2e11, 0.25});

struct Sensed {
  explicit Sensed(const TaxelLayout& layout) : p(layout.size()), x(layout.size()), y(layout.size()) {}
  std::vector<float> p, x, y;
};

TEST(ContactFields, WithoutSkinAndOfASphereAreTheTaxelAveragesOfTheContact) {
  LoadHistory contact(kSensedPair);
  contact.move_to(2, 0.7, 0.5);
  contact.move_to(3, 0.3, 0.5);
  const auto layout = TaxelLayout::grid(16, 16, 0.001);
  Sensed sensed(layout);
  ContactField sheet(layout, {});
  sheet.sense(contact, 0.0013, -0.0007, 0, sensed.p, sensed.x, sensed.y);
  std::vector<float> p(layout.size()), q(layout.size());
  taxel_averages(layout, 0.0013, -0.0007, contact, p, q);
  const float peak = *std::max_element(p.begin(), p.end());
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_NEAR(sensed.p[i], p[i], 7e-4F * peak);
    EXPECT_NEAR(sensed.x[i], q[i], 7e-4F * peak);
    EXPECT_NEAR(sensed.y[i], 0, 1e-4F * peak);
  }
}

// Wide pads sense nearly all; what is missing lies beyond the pad.
TEST(ContactFields, OfAnyShapeCarryTheForcesOfTheirHistory) {
  LoadHistory contact(kSensedPair);
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.6, 0.5);
  contact.move_to(2.5, 0.3, 0.5);
  const auto layout = TaxelLayout::grid(64, 64, 0.0005);
  for (const ContactGeometry& geometry :
       {ContactGeometry{.stretch = 2, .angle_rad = 0.5}, ContactGeometry{.power = 6},
        ContactGeometry{.depth_m = 0.001}, ContactGeometry{.depth_m = 0.001, .stretch = 1.5, .power = 4}}) {
    Sensed sensed(layout);
    ContactField sheet(layout, geometry);
    sheet.sense(contact, 0.0003, -0.0002, 0.8, sensed.p, sensed.x, sensed.y);
    double normal = 0, x = 0, y = 0;
    for (std::size_t i = 0; i < sensed.p.size(); ++i) {
      normal += sensed.p[i] * layout.area_m2();
      x += sensed.x[i] * layout.area_m2();
      y += sensed.y[i] * layout.area_m2();
    }
    const double lost = geometry.depth_m > 0 ? 0.06 : 3e-4;
    EXPECT_NEAR(normal, 2.5, 2.5 * lost);
    EXPECT_NEAR(std::hypot(x, y), 0.3, 0.3 * (geometry.depth_m > 0 ? 0.1 : 6e-4));
    EXPECT_NEAR(std::atan2(y, x), 0.8, lost);
  }
}

}  // namespace
}  // namespace slipd::contact
