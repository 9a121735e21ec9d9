#include "core/contact/hertz.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "precise.hpp"

namespace slipd::contact {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Body kSkin{0.01, 0.5e6, 0.45};

TEST(Hertz, AgreesWithFourHundredDigitsFromSoftToStiffAndConcaveToFlat) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 300; ++i) {
    const double concave = -0.01 * (1 + std::pow(10.0, -12 * unit(random)));
    const Body object{i % 3 == 0   ? kInf
                      : i % 3 == 1 ? concave
                                   : std::pow(10.0, -6 + 12 * unit(random)),
                      std::pow(10.0, 2 + 12 * unit(random)), -0.9 + 1.4 * unit(random)};
    const double normal = std::pow(10.0, -9 + 12 * unit(random));
    const BodyPair pair = make_body_pair(kSkin, object);
    const auto want = precise::reference(kSkin, object, normal, 0.5, 0.5, 0.5);
    EXPECT_LT(precise::error(pair.modulus_pa, want.modulus), 1e-14);
    EXPECT_LT(precise::error(pair.radius_m, want.radius), 1e-14);
    EXPECT_LT(precise::error(pair.contact_radius_m(normal), want.a), 1e-14);
    EXPECT_LT(precise::error(pair.peak_pressure_pa(normal), want.p0), 1e-14);
  }
}

TEST(Hertz, ADiscAsWideAsTheContactCarriesTheNormalForce) {
  const BodyPair pair = make_body_pair(kSkin, {kInf, 2e11, 0.3});
  for (const double normal : {1e-9, 1.0, 1e3}) {
    EXPECT_NEAR(pair.disc_force_n(pair.contact_radius_m(normal)) / normal, 1, 1e-14);
    EXPECT_NEAR(pair.disc_scale_pa_per_m() * pair.contact_radius_m(normal) / pair.peak_pressure_pa(normal), 1,
                1e-14);
  }
}

TEST(Hertz, NoForceMeansNoExtentAndNoPressure) {
  const BodyPair pair = make_body_pair(kSkin, {kInf, 2e11, 0.3});
  EXPECT_EQ(pair.contact_radius_m(0), 0);
  EXPECT_EQ(pair.peak_pressure_pa(0), 0);
}

TEST(Hertz, InvalidBodiesAreRefusedByName) {
  const auto message = [](const Body& object) -> std::string {
    try {
      make_body_pair(kSkin, object);
    } catch (const ContactError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message({0.01, 1e6, 0.51}).find("nu2 = 0.51"), std::string::npos);
  EXPECT_NE(message({0.01, 1e6, -1}).find("nu2"), std::string::npos);
  EXPECT_NE(message({0.01, 1e6, kNan}).find("nu2"), std::string::npos);
  EXPECT_NE(message({0.01, 0, 0.3}).find("E2"), std::string::npos);
  EXPECT_NE(message({0.01, kInf, 0.3}).find("E2"), std::string::npos);
  EXPECT_NE(message({kNan, 1e6, 0.3}).find("R2"), std::string::npos);
  EXPECT_NE(message({0, 1e6, 0.3}).find("R2"), std::string::npos);
  EXPECT_NE(message({-0.01, 1e6, 0.3}).find("1/R1 + 1/R2"), std::string::npos);
  EXPECT_NE(message({-0.005, 1e6, 0.3}).find("1/R1 + 1/R2"), std::string::npos);
  EXPECT_EQ(message({-0.02, 1e6, 0.5}), "accepted");
  EXPECT_THROW(make_body_pair({kInf, 1e6, 0.3}, {kInf, 1e6, 0.3}), ContactError);
  constexpr Body kSpeck{std::numeric_limits<double>::denorm_min(), 1e6, 0.3};
  EXPECT_THROW(make_body_pair(kSpeck, kSpeck), ContactError) << "half the least radius is none";
}

TEST(Hertz, ForcesAndFrictionWithoutMeaningAreRefused) {
  for (const double bad : {-1.0, -1e-300, kInf, kNan}) EXPECT_THROW(check_normal_force(bad), ContactError);
  for (const double bad : {0.0, -0.5, kInf, kNan}) EXPECT_THROW(check_friction(bad), ContactError);
  EXPECT_NO_THROW(check_normal_force(0));
}

}  // namespace
}  // namespace slipd::contact
