#include "core/contact/subsurface/rigid_base.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "core/contact/contact_field.hpp"
#include "core/contact/subsurface/subsurface.hpp"

namespace slipd::contact {
namespace {

using Sheet = SubsurfaceSheet;
using Matrix = Eigen::Matrix<double, 6, 6>;
constexpr std::array kAllDomes{Sheet::nn, Sheet::nx, Sheet::ny, Sheet::xx,
                               Sheet::xy, Sheet::yy, Sheet::xn, Sheet::yn};

// Equilibrium of an elastic layer, shear modulus 1, through its thickness 1 from the surface down, of waves
// along x: displacements i U, W and across V, the stresses s_xz = i T, s_zz = S and s_yz = Y, as Navier and
// Hooke have it. Integrated numerically (Runge-Kutta), for one wave number.
Matrix from_surface_to_base(double k, double poisson) {
  const double lame = 2 * poisson / (1 - 2 * poisson), c = lame + 2;
  Matrix slope = Matrix::Zero();  // of U, W, V, T, S, Y
  slope(0, 1) = -k;
  slope(0, 3) = 1;
  slope(1, 0) = lame * k / c;
  slope(1, 4) = 1 / c;
  slope(2, 5) = 1;
  slope(3, 0) = k * k * (c - lame * lame / c);
  slope(3, 4) = -k * lame / c;
  slope(4, 3) = k;
  slope(5, 2) = k * k;
  constexpr int kSteps = 400;
  const Matrix hz = slope / kSteps;
  const Matrix step = Matrix::Identity() + hz + hz * hz / 2 + hz * hz * hz / 6 + hz * hz * hz * hz / 24;
  Matrix all = Matrix::Identity();
  for (int i = 0; i < kSteps; ++i) all = step * all;
  return all;
}

// The stresses at the base, which does not move, by those on the surface.
Eigen::Matrix3d base_by_surface(double k, double poisson) {
  const Matrix all = from_surface_to_base(k, poisson);
  const Eigen::Matrix3d moved = all.topLeftCorner<3, 3>().inverse() * all.topRightCorner<3, 3>();
  return all.bottomRightCorner<3, 3>() - all.bottomLeftCorner<3, 3>() * moved;
}

TEST(RigidBase, TransfersAreThoseOfNavierAndHookeThroughTheLayer) {
  for (const double poisson : {0.0, 0.2, 0.45, 0.495}) {
    for (const double k : {0.05, 0.4, 1.0, 2.5, 5.0}) {
      const LayerTransfer of = layer_transfer(k, poisson);
      // Of T, S, Y. Tractions p and q on the sensor are s_zz = -p and s_xz = -q: T = i q, S = -p.
      const Eigen::Matrix3d truth = base_by_surface(k, poisson);
      EXPECT_NEAR(of.along, truth(0, 0), 1e-7) << k << " " << poisson;
      EXPECT_NEAR(of.tangential_of_normal, -truth(0, 1), 1e-7) << k << " " << poisson;
      EXPECT_NEAR(of.normal_of_tangential, truth(1, 0), 1e-7) << k << " " << poisson;
      EXPECT_NEAR(of.normal, truth(1, 1), 1e-7) << k << " " << poisson;
      EXPECT_NEAR(of.across, truth(2, 2), 1e-7) << k << " " << poisson;
    }
  }
}

TEST(RigidBase, LongWavesPassAndPressingPressesOutwardsByLessThanItIsPulled) {
  const LayerTransfer of = layer_transfer(1e-4, 0.45);
  EXPECT_NEAR(of.normal, 1, 1e-7);
  EXPECT_NEAR(of.along, 1, 1e-7);
  EXPECT_NEAR(of.across, 1, 1e-7);
  EXPECT_NEAR(of.normal_of_tangential, 1e-4, 1e-8);                // the moment of a pull
  EXPECT_NEAR(of.tangential_of_normal, 1e-4 * 0.45 / 0.55, 1e-8);  // rubber that cannot widen
  EXPECT_EQ(layer_transfer(1, 0.5).normal_of_tangential, layer_transfer(1, 0.5).tangential_of_normal);
  EXPECT_TRUE(std::isfinite(layer_transfer(900, 0.45).normal));
}

// The dome's spectrum times the transfer functions, by Gauss's rule over wave numbers and even directions;
// the layer's thickness is 1.
LayerTensor layer_by_quadrature(const Ellipse& dome, double poisson, double x, double y) {
  using Rule = boost::math::quadrature::gauss<double, 20>;
  constexpr int kPanels = 16, kDirections = 48;
  constexpr double kMost = 16;
  const double c = std::cos(dome.angle_rad), s = std::sin(dome.angle_rad), width = kMost / kPanels;
  LayerTensor sum;
  const auto add = [&](double k, double weight) {
    const LayerTransfer of = layer_transfer(k, poisson);
    for (int j = 0; j < kDirections; ++j) {  // the other half is alike
      const double around = std::numbers::pi * j / kDirections, ex = std::cos(around), ey = std::sin(around);
      const double q = k * std::hypot(dome.a_m * (c * ex + s * ey), dome.b_m * (c * ey - s * ex));
      const double spectrum = dome.a_m * dome.b_m * (std::sin(q) - q * std::cos(q)) / (q * q * q);
      const double w = weight * k * spectrum / kDirections, phase = k * (ex * x + ey * y);
      const double even = w * std::cos(phase), odd = w * std::sin(phase), apart = of.along - of.across;
      sum.nn += of.normal * even;
      sum.nx += of.normal_of_tangential * ex * odd;
      sum.ny += of.normal_of_tangential * ey * odd;
      sum.xx += (of.across + apart * ex * ex) * even;
      sum.xy += apart * ex * ey * even;
      sum.yy += (of.across + apart * ey * ey) * even;
      sum.xn += of.tangential_of_normal * ex * odd;
      sum.yn += of.tangential_of_normal * ey * odd;
    }
  };
  for (int panel = 0; panel < kPanels; ++panel) {
    for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
      for (const double sign : {-1.0, 1.0})
        add(width * (panel + 0.5 + 0.5 * sign * Rule::abscissa()[i]), 0.5 * width * Rule::weights()[i]);
    }
  }
  return sum;
}
std::array<double, 8> list_of(const LayerTensor& t) {
  return {t.nn, t.nx, t.ny, t.xx, t.xy, t.yy, t.xn, t.yn};
}

TEST(RigidBase, IsSensedWithinFourTenThousandthsOfThePeak) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> unit(0, 1);
  double worst = 0;
  for (const double poisson : {0.3, 0.45, 0.5}) {
    for (const double a : {0.3, 1.0, 3.0, 8.0}) {
      for (const double axes : {1.0, 0.6}) {
        const Ellipse dome{a, a * axes, 3 * unit(random)};
        const double peak = layer_by_quadrature(dome, poisson, 0, 0).nn;
        std::vector<double> u, v;
        for (int i = 0; i < 3; ++i) {
          u.push_back((a + 1.5) * (2 * unit(random) - 1));
          v.push_back((a + 1.5) * (2 * unit(random) - 1));
        }
        Sheet sheet(u.size(), 0.2, 1, poisson);
        sheet.evaluate_values(dome, u, v, Sheet::Detail::centre);
        for (std::size_t i = 0; i < u.size(); ++i) {
          const auto truth = list_of(layer_by_quadrature(dome, poisson, u[i], v[i]));
          for (std::size_t j = 0; j < kAllDomes.size(); ++j) {
            const double error = std::fabs(sheet.row(Sheet::value, kAllDomes[j])[i] - truth[j]) / peak;
            EXPECT_LT(error, 4e-4) << poisson << " " << a << " " << axes << " component " << j;
            worst = std::max(worst, error);
          }
        }
      }
    }
  }
  RecordProperty("worst", std::to_string(worst));
}

TEST(RigidBase, AveragesOverTaxelsAreThoseOfManyPoints) {
  constexpr int kFine = 24;
  for (const double side : {0.25, 0.5, 1.0, 2.0}) {
    for (const double b : {3.0, 1.7}) {
      const Ellipse dome{3, b, 0.4};
      const std::vector<double> u{0.3, 2.0, 2.9}, v{-0.2, 1.3, 0.4};
      std::vector<double> fine_u, fine_v;
      for (std::size_t i = 0; i < u.size(); ++i) {
        for (int j = 0; j < kFine * kFine; ++j) {
          fine_u.push_back(u[i] + side * ((j / kFine + 0.5) / kFine - 0.5));
          fine_v.push_back(v[i] + side * ((j % kFine + 0.5) / kFine - 0.5));
        }
      }
      Sheet sheet(u.size(), side, 1, 0.45), fine(fine_u.size(), side, 1, 0.45);
      sheet.evaluate_values(dome, u, v);
      fine.evaluate_values(dome, fine_u, fine_v, Sheet::Detail::centre);
      for (const auto component : kAllDomes) {
        for (std::size_t i = 0; i < u.size(); ++i) {
          double mean = 0;
          for (std::size_t j = 0; j < kFine * kFine; ++j)
            mean += fine.row(Sheet::value, component)[i * kFine * kFine + j] / (kFine * kFine);
          EXPECT_NEAR(sheet.row(Sheet::value, component)[i], mean, 2e-4) << side << " " << int{component};
        }
      }
    }
  }
}

TEST(RigidBase, SlopesAreThoseOfTheValues) {
  const std::vector<double> u{0.1, -0.8, 1.3, 0.5}, v{0.6, 0.2, -0.9, -1.1};
  constexpr double kStep = 1e-4;
  for (const double b : {1.0, 0.6}) {
    const bool round = b == 1;
    Sheet sheet(u.size(), 0.2, 0.6, 0.45), plus(u.size(), 0.2, 0.6, 0.45), minus(u.size(), 0.2, 0.6, 0.45);
    const Ellipse dome{1, b, 0.7};
    sheet.evaluate(dome, u, v);
    const auto differ = [&](Sheet::Of of, const Ellipse& by, double du) {
      std::vector<double> u1 = u, u0 = u;
      for (auto& x : u1) x += kStep * du;
      for (auto& x : u0) x -= kStep * du;
      const auto moved = [&](double step) {
        return Ellipse{dome.a_m + step * by.a_m, dome.b_m + step * by.b_m,
                       dome.angle_rad + step * by.angle_rad};
      };
      plus.evaluate_values(moved(kStep), u1, v);
      minus.evaluate_values(moved(-kStep), u0, v);
      for (const auto c : kAllDomes) {
        for (std::size_t i = 0; i < u.size(); ++i)
          EXPECT_NEAR(sheet.row(of, c)[i],
                      (plus.row(Sheet::value, c)[i] - minus.row(Sheet::value, c)[i]) / (2 * kStep), 1e-4)
              << b << " row " << int{of} << " component " << int{c};
      }
    };
    differ(Sheet::d_u, {0, 0, 0}, 1);
    differ(Sheet::d_a, {1, round ? 1.0 : 0.0, 0}, 0);
    plus.set_depth(0.6 * std::exp(kStep));
    minus.set_depth(0.6 * std::exp(-kStep));
    differ(Sheet::d_depth, {0, 0, 0}, 0);
    plus.set_depth(0.6);
    minus.set_depth(0.6);
    if (round) continue;
    differ(Sheet::d_b, {0, 1, 0}, 0);
    differ(Sheet::d_angle, {0, 0, 1}, 0);
  }
}

TEST(RigidBase, ContactsCarryTheForcesOfTheirHistory) {
  const BodyPair pair =
      make_body_pair({0.01, 0.5e6, 0.45}, {std::numeric_limits<double>::infinity(), 2e11, 0.25});
  LoadHistory contact(pair);
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.6, 0.5);
  const auto layout = TaxelLayout::grid(64, 64, 0.0005);
  ContactField sheet(layout, {.depth_m = 0.001, .bonded_poisson = 0.45});
  std::vector<float> p(layout.size()), x(layout.size()), y(layout.size());
  sheet.sense(contact, 0.0003, -0.0002, 0.8, p, x, y);
  double normal_n = 0, x_n = 0, y_n = 0;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    normal_n += p[i] * layout.area_m2();
    x_n += x[i] * layout.area_m2();
    y_n += y[i] * layout.area_m2();
  }
  EXPECT_NEAR(normal_n, 2, 0.004);  // the base ends what a half space would spread beyond the pad
  EXPECT_NEAR(std::hypot(x_n, y_n), 0.6, 0.002);
  EXPECT_NEAR(std::atan2(y_n, x_n), 0.8, 0.003);
}

}  // namespace
}  // namespace slipd::contact
