#include "core/contact/cattaneo_mindlin.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "precise.hpp"

namespace slipd::contact {
namespace {

constexpr double kFlatBody = std::numeric_limits<double>::infinity();
constexpr Body kPad{0.01, 0.5e6, 0.45};
constexpr Body kFlat{kFlatBody, 2e11, 0.25};

TEST(CattaneoMindlin, AgreesWithFourHundredDigitsAtTheExtremesOfLoadAndPlace) {
  const BodyPair pair = make_body_pair(kPad, kFlat);
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 400; ++i) {
    const double tiny = std::pow(10.0, -300 * unit(random) * unit(random));
    const double load = i % 4 == 0   ? 1 - std::pow(10.0, -15 * unit(random))
                        : i % 4 == 1 ? tiny
                                     : unit(random);
    const double stick = std::cbrt(1 - load);
    // Anywhere, near the rim, and just inside and outside the edge of the stick zone, where cancellation is
    // worst.
    const double s = i % 3 == 0   ? unit(random)
                     : i % 3 == 1 ? 1 - std::pow(10.0, -15 * unit(random))
                                  : std::min(1.0, stick * (1 + 1e-6 * (unit(random) - 0.5)));
    const double normal = std::pow(10.0, -9 + 12 * unit(random)),
                 friction = std::pow(10.0, -6 + 6.7 * unit(random));
    const CattaneoMindlin contact(pair, normal, friction, load);
    const auto got = contact.at(s);
    const auto want = precise::reference(kPad, kFlat, normal, friction, load, s);
    // At the edge of the stick zone the ratio falls like the root of the distance. An error of 1e-12
    // therefore needs the distance to sixteen digits. 1 - Gamma gives them, a rounded k would not.
    EXPECT_LT(precise::error(got.pressure_pa, want.pressure), 1e-12) << "load " << load << " s " << s;
    EXPECT_LT(precise::error(got.shear_pa, want.traction), 1e-12) << "load " << load << " s " << s;
    EXPECT_LT(precise::error(got.angle_rad, want.angle), 1e-12) << "load " << load << " s " << s;
    EXPECT_LT(precise::error(contact.shear_n(), want.shear), 1e-14);
    EXPECT_LT(precise::error(contact.stick_radius_m(), want.c), 1e-14);
  }
}

TEST(CattaneoMindlin, AgreesWithTheSharedReferenceTable) {
  const char* shared = std::getenv("SLIPD_SHARED");
  const std::filesystem::path file =
      std::filesystem::path(shared != nullptr ? shared : SLIPD_SOURCE_DIR "/../shared") /
      "data/contact_reference.csv";
  if (!std::filesystem::exists(file))
    GTEST_SKIP() << "needs " << file << ", which is not part of the project";
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  int rows = 0;
  while (std::getline(in, line)) {
    std::vector<double> v;
    std::stringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) {
      v.push_back(std::strtod(cell.c_str(), nullptr));
    }
    ASSERT_EQ(v.size(), 19U);
    const BodyPair pair = make_body_pair({v[2], v[3], v[4]}, {v[5], v[6], v[7]});
    const CattaneoMindlin contact(pair, v[0], v[1], v[8]);
    const auto at = contact.at(v[9]);
    const double got[] = {pair.modulus_pa,
                          pair.radius_m,
                          contact.contact_radius_m(),
                          contact.peak_pressure_pa(),
                          contact.stick_radius_m(),
                          contact.shear_n(),
                          at.pressure_pa,
                          at.shear_pa,
                          at.angle_rad};
    for (std::size_t i = 0; i < 9; ++i) {
      EXPECT_LT(precise::error(got[i], precise::Real(v[10 + i])), 1e-12)
          << "column " << 10 + i << ": " << line;
    }
    ++rows;
  }
  EXPECT_GE(rows, 400);
}

TEST(CattaneoMindlin, IntegralsReturnTheForces) {
  const BodyPair pair = make_body_pair(kPad, kFlat);
  for (const double load : {0.0, 1e-6, 0.3, 0.9, 1.0}) {
    const CattaneoMindlin contact(pair, 2, 0.4, load);
    const double a = contact.contact_radius_m();
    double normal = 0, shear = 0;
    // midpoint rule on r dr; the root at the rim limits it to kRings^-1.5, here 1e-8
    constexpr int kRings = 200000;
    for (int i = 0; i < kRings; ++i) {
      const double s = (i + 0.5) / kRings;
      const double ring = 2 * std::numbers::pi * s * a * a / kRings;
      normal += contact.at(s).pressure_pa * ring;
      shear += contact.at(s).shear_pa * ring;
    }
    EXPECT_NEAR(normal / 2, 1, 1e-7);
    EXPECT_NEAR(shear, contact.shear_n(), 1e-7);
  }
}

TEST(CattaneoMindlin, AngleRisesWithRadiusAndWithLoadUpToFriction) {
  const BodyPair pair = make_body_pair(kPad, kFlat);
  for (double load = 0.05; load <= 1; load += 0.05) {
    const CattaneoMindlin contact(pair, 1, 0.6, std::min(load, 1.0));
    const CattaneoMindlin lighter(pair, 1, 0.6, load - 0.05);
    double before = 0;
    for (double s = 0; s <= 1; s += 0.01) {
      const double angle = contact.at(s).angle_rad;
      EXPECT_GE(angle, before);
      EXPECT_GE(angle, lighter.at(s).angle_rad);
      EXPECT_LE(angle, std::atan(0.6));
      before = angle;
    }
  }
}

TEST(CattaneoMindlin, TractionIsZeroOutsideTheContactAndWithoutForce) {
  const BodyPair pair = make_body_pair(kPad, kFlat);
  const auto outside = CattaneoMindlin(pair, 1, 0.5, 0.5).at(1.0000001);
  EXPECT_EQ(outside.pressure_pa, 0);
  EXPECT_EQ(outside.shear_pa, 0);
  EXPECT_EQ(outside.angle_rad, 0);
  const auto untouched = CattaneoMindlin(pair, 0, 0.5, 0.5).at(0.5);
  EXPECT_EQ(untouched.pressure_pa, 0);
  EXPECT_EQ(untouched.shear_pa, 0);
}

TEST(CattaneoMindlin, InvalidLoadsAreRefused) {
  const BodyPair pair = make_body_pair(kPad, kFlat);
  EXPECT_THROW(CattaneoMindlin(pair, 1, 0.5, -1e-12), ContactError);
  EXPECT_THROW(CattaneoMindlin(pair, 1, 0.5, 1.0000001), ContactError);
  EXPECT_THROW(CattaneoMindlin(pair, 1, 0.5, std::nan("")), ContactError);
  EXPECT_THROW(CattaneoMindlin(pair, -1, 0.5, 0.5), ContactError);
  EXPECT_THROW(CattaneoMindlin(pair, 1, 0, 0.5), ContactError);
}

}  // namespace
}  // namespace slipd::contact
