#include "core/contact/history.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/contact/cattaneo_mindlin.hpp"

namespace slipd::contact {
namespace {

const BodyPair kPair =
    make_body_pair({0.01, 0.5e6, 0.45}, {std::numeric_limits<double>::infinity(), 2e11, 0.25});

double total_shear_n(const LoadHistory& contact) {
  double sum = 0;
  for (const auto& term : contact.shear_terms()) sum += term.coefficient * kPair.disc_force_n(term.radius_m);
  return sum;
}

double largest_excess_over_friction(const LoadHistory& contact) {
  const double a = contact.contact_radius_m();
  double worst = 0;
  for (double s = 0; s < 1; s += 0.001) {
    const double most = contact.friction() * contact.pressure_pa(s * a);
    worst = std::max(
        worst, (std::fabs(contact.shear_pa(s * a)) - most) / kPair.peak_pressure_pa(contact.normal_n()));
  }
  return worst;
}

// Mean square radius of shear over that of pressure: 1 to 5/3 under monotonic loading.
double moment_ratio(const LoadHistory& contact) {
  double q = 0, q2 = 0;
  for (const auto& term : contact.shear_terms()) {
    const double force = term.coefficient * kPair.disc_force_n(term.radius_m);
    q += force;
    q2 += force * 0.4 * term.radius_m * term.radius_m;
  }
  return q2 / q / (0.4 * std::pow(contact.contact_radius_m(), 2));
}

// The largest difference between the shear of two contacts, relative to mu times the peak pressure.
double distance(const LoadHistory& one, const LoadHistory& two) {
  const double a = one.contact_radius_m();
  double worst = 0;
  for (double s = 0; s < 1; s += 0.002)
    worst = std::max(worst, std::fabs(one.shear_pa(s * a) - two.shear_pa(s * a)));
  return worst / (one.friction() * kPair.peak_pressure_pa(one.normal_n()));
}

// At the edge of a stick zone the dome of its disc rises like a root. A radius known to 1e-16 therefore
// gives the traction to 1e-8.
constexpr double kRoot = 1e-7;

TEST(LoadHistory, ARisingLoadIsCattaneoAndMindlins) {
  for (const double load : {1e-3, 0.2, 0.8, 0.999}) {
    LoadHistory contact(kPair);
    contact.move_to(2, 0, 0.5);
    contact.move_to(2, load * 0.5 * 2, 0.5);
    const CattaneoMindlin closed(kPair, 2, 0.5, load);
    for (double s = 0; s < 1; s += 0.01) {
      EXPECT_NEAR(contact.shear_pa(s * closed.contact_radius_m()), closed.at(s).shear_pa,
                  kRoot * closed.peak_pressure_pa());
    }
    EXPECT_NEAR(contact.safety_margin(), 1 - load, 1e-12);
  }
}

TEST(LoadHistory, RegripAtConstantShearLeavesTheFamilyAsWorkedOut) {
  LoadHistory contact(kPair);
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.8, 0.5);
  EXPECT_NEAR(contact.safety_margin(), 0.2, 1e-12);
  contact.move_to(3, 0.8, 0.5);
  EXPECT_NEAR(contact.safety_margin(), 1 - 0.8 / 1.5, 1e-12);  // 0.467
  EXPECT_NEAR(moment_ratio(contact), 0.889, 5e-4);
  // The new ring carries no shear. Inside it the traction is unchanged: mu (D_a - D_c).
  const double a = kPair.contact_radius_m(2);
  EXPECT_NEAR(contact.shear_pa(1.01 * a), 0, 1e-6);
  const CattaneoMindlin before(kPair, 2, 0.5, 0.8);
  EXPECT_NEAR(contact.shear_pa(0.5 * a), before.at(0.5).shear_pa, kRoot * before.peak_pressure_pa());
}

TEST(LoadHistory, LoadingOnAfterRegripSlipsInwardsUntilTheMemoryIsWiped) {
  LoadHistory contact(kPair), fresh(kPair);
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.8, 0.5);
  contact.move_to(3, 0.8, 0.5);
  contact.move_to(3, 1.45, 0.5);
  fresh.move_to(3, 0, 0.5);
  fresh.move_to(3, 1.45, 0.5);
  EXPECT_LT(distance(contact, fresh), kRoot);
}

TEST(LoadHistory, ReversalIsMindlinAndDeresiewiczsLoop) {
  LoadHistory contact(kPair);
  contact.move_to(2, 0, 0.5);
  contact.move_to(2, 0.8, 0.5);
  contact.move_to(2, 0.2, 0.5);
  // q = mu (D_a - D_c) - 2 mu (D_a - D_b). b follows from the decrease of Q: P(b) = P - dQ/(2 mu).
  const double a = kPair.contact_radius_m(2);
  const double c = a * std::cbrt(0.2), b = a * std::cbrt(1 - 0.6 / (2 * 0.5 * 2));
  const auto dome = [](double x, double r) { return r < x ? std::sqrt(x * x - r * r) : 0.0; };
  for (double r = 0; r < a; r += a / 100) {
    const double want =
        kPair.disc_scale_pa_per_m() * 0.5 * (dome(a, r) - dome(c, r) - 2 * (dome(a, r) - dome(b, r)));
    EXPECT_NEAR(contact.shear_pa(r), want, kRoot * kPair.peak_pressure_pa(2));
  }
  LoadHistory back = contact;
  back.move_to(2, -0.8, 0.5);
  LoadHistory mirrored(kPair);
  mirrored.move_to(2, 0, 0.5);
  mirrored.move_to(2, -0.8, 0.5);
  EXPECT_LT(distance(back, mirrored), kRoot) << "the loop closes: what was before the reversal is forgotten";
}

TEST(LoadHistory, UnloadingAtConstantShearKeepsTheStickZoneThatTheForcesAskFor) {
  LoadHistory contact(kPair);
  contact.move_to(3, 0, 0.5);
  contact.move_to(3, 0.6, 0.5);
  contact.move_to(2, 0.6, 0.5);
  const CattaneoMindlin closed(kPair, 2, 0.5, 0.6);
  for (double s = 0; s < 1; s += 0.01) {
    EXPECT_NEAR(contact.shear_pa(s * closed.contact_radius_m()), closed.at(s).shear_pa,
                kRoot * closed.peak_pressure_pa());
  }
}

TEST(LoadHistory, ForcesThatGrowTogetherBelowFrictionStickEverywhere) {
  LoadHistory contact(kPair);
  contact.move_to(1, 0.2, 0.5);
  contact.move_to(3, 0.6, 0.5);
  for (double s = 0; s < 1; s += 0.01) {
    const double r = s * contact.contact_radius_m();
    EXPECT_NEAR(contact.shear_pa(r), 0.2 * contact.pressure_pa(r), kRoot * kPair.peak_pressure_pa(3));
  }
}

TEST(LoadHistory, AnOverloadSlidesAndIsCarriedOnlyAsFarAsFrictionHolds) {
  LoadHistory contact(kPair);
  contact.move_to(2, 5, 0.5);
  EXPECT_DOUBLE_EQ(contact.shear_n(), 1);
  EXPECT_DOUBLE_EQ(contact.safety_margin(), 0);
  contact.move_to(2, 5, 0.3);
  EXPECT_DOUBLE_EQ(contact.shear_n(), 0.6);
}

TEST(LoadHistory, FrictionThatFallsUnderALoadSlipsFurtherIn) {
  LoadHistory contact(kPair), weak(kPair);
  contact.move_to(2, 0, 0.8);
  contact.move_to(2, 0.4, 0.8);
  contact.move_to(2, 0.4, 0.4);
  weak.move_to(2, 0, 0.4);
  weak.move_to(2, 0.4, 0.4);
  EXPECT_LT(distance(contact, weak), kRoot);
  EXPECT_NEAR(contact.safety_margin(), 0.5, 1e-12);
}

TEST(LoadHistory, LettingGoForgetsEverything) {
  LoadHistory contact(kPair), fresh(kPair);
  contact.move_to(2, 0.8, 0.5);
  contact.move_to(0, 0, 0.5);
  EXPECT_TRUE(std::isnan(contact.safety_margin()));
  EXPECT_TRUE(contact.shear_terms().empty());
  contact.move_to(1, 0.1, 0.5);
  fresh.move_to(1, 0.1, 0.5);
  EXPECT_LT(distance(contact, fresh), 1e-12);
}

TEST(LoadHistory, AForceThatIsTooSmallForAnyExtentLetsGo) {
  LoadHistory contact(kPair);
  contact.move_to(2, 0.4, 0.5);
  contact.move_to(std::numeric_limits<double>::denorm_min(), 0, 0.5);
  EXPECT_TRUE(std::isnan(contact.safety_margin()));
  EXPECT_TRUE(contact.shear_terms().empty());
}

// One spring per point of the one-dimensional foundation, loaded in many small steps: an independent truth
// by brute force.
class Springs {
 public:
  explicit Springs(double reach_m) : step_(reach_m / kCount), t_(kCount, 0) {}
  void move_to(double normal_n, double shear_n, double friction) {
    for (int i = 1; i <= kSteps; ++i) {
      const double f = static_cast<double>(i) / kSteps;
      settle(normal_ + f * (normal_n - normal_), shear_ + f * (shear_n - shear_), friction);
    }
    normal_ = normal_n;
    shear_ = shear_n;
  }
  double at(double x) const { return t_[static_cast<std::size_t>(x / step_)]; }

 private:
  static constexpr int kCount = 4000, kSteps = 400;
  void settle(double normal_n, double shear_n, double friction) {
    const double edge = std::pow(kPair.contact_radius_m(normal_n), 2);
    double low = -4 * friction * edge, high = -low;
    std::vector<double> moved(t_.size());
    for (int i = 0; i < 60; ++i) {
      const double shift = 0.5 * (low + high);
      double sum = 0;
      for (std::size_t j = 0; j < t_.size(); ++j) {
        const double x = (static_cast<double>(j) + 0.5) * step_;
        const double most = friction * std::max(0.0, edge - x * x);
        moved[j] = std::clamp(t_[j] + shift, -most, most);
        sum += moved[j];
      }
      (2 * kPair.modulus_pa / kPair.radius_m * sum * step_ > shear_n ? high : low) = shift;
    }
    t_ = moved;
  }
  double step_, normal_ = 0, shear_ = 0;
  std::vector<double> t_;
};

TEST(LoadHistory, AgreesWithSpringsLoadedInSmallStepsOnAnyPath) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 3; ++trial) {
    LoadHistory contact(kPair);
    Springs springs(1.01 * kPair.contact_radius_m(4));
    for (int step = 0; step < 5; ++step) {
      const double normal = 1 + 3 * unit(random), shear = 0.95 * (2 * unit(random) - 1) * 0.5 * normal;
      contact.move_to(normal, shear, 0.5);
      springs.move_to(normal, shear, 0.5);
      const double edge = std::pow(contact.contact_radius_m(), 2);
      for (double s = 0.005; s < 1; s += 0.05) {
        const double x = s * contact.contact_radius_m();
        double t = 0;
        for (const auto& term : contact.shear_terms()) {
          t += term.coefficient * std::max(0.0, term.radius_m * term.radius_m - x * x);
        }
        // 4000 springs and 400 steps a path resolve each knot to about half a percent of the friction limit.
        EXPECT_NEAR(t / (0.5 * edge), springs.at(x) / (0.5 * edge), 0.01)
            << "trial " << trial << " step " << step;
      }
    }
  }
}

// A greater friction leaves a curve that is steeper than the limits of the smaller friction. Unloading then
// reaches both limits.
TEST(LoadHistory, AgreesWithSpringsWhereTheLoadIsTakenOffAfterFrictionFell) {
  struct Step {
    double normal_n, shear_n, friction;
  };
  const std::vector<Step> paths[] = {
      {{3, 0, 0.8}, {3, 2.2861, 0.8}, {3, -0.1273, 0.8}, {3, -0.1273, 0.116}, {0.599, 0.0617, 0.116}},
      {{3, 0, 0.8}, {3, 2.4, 0.8}, {3, -0.1273, 0.8}, {3, -0.1273, 0.116}, {0.599, 0.0617, 0.116}},
      // Steep from the middle outwards, because the whole contact has stuck.
      {{2.797, 1.618, 0.968}, {0.257, 0.0134, 0.968}, {0.257, 0.0134, 0.225}, {0.13, 0.0281, 0.225}},
  };
  for (const auto& path : paths) {
    for (const double sign : {1.0, -1.0}) {
      LoadHistory contact(kPair), stepwise(kPair);
      Springs springs(1.01 * kPair.contact_radius_m(path.front().normal_n));
      for (const Step& to : path) {
        stepwise = contact;
        contact.move_to(to.normal_n, sign * to.shear_n, to.friction);
        if (sign > 0) springs.move_to(to.normal_n, to.shear_n, to.friction);
      }
      const Step from = path[path.size() - 2], to = path.back();
      for (int i = 1; i <= 2000; ++i) {
        const double f = i / 2000.0;
        stepwise.move_to(from.normal_n + f * (to.normal_n - from.normal_n),
                         sign * (from.shear_n + f * (to.shear_n - from.shear_n)), to.friction);
      }
      EXPECT_LT(distance(contact, stepwise), 0.02) << "64 parts place a knot to a percent of the contact";
      if (sign < 0) continue;  // the mirror image
      const double edge = std::pow(contact.contact_radius_m(), 2);
      for (double s = 0.05; s < 1; s += 0.1) {
        const double x = s * contact.contact_radius_m();
        double t = 0;
        for (const auto& term : contact.shear_terms())
          t += term.coefficient * std::max(0.0, term.radius_m * term.radius_m - x * x);
        EXPECT_NEAR(t / (to.friction * edge), springs.at(x) / (to.friction * edge), 0.02) << s;
      }
    }
  }
}

TEST(LoadHistory, WhereFrictionFellNothingHoldsMoreThanItHoweverSmallTheLoad) {
  for (const double normal : {1e-6, 0.5, 2.0}) {
    LoadHistory contact(kPair);
    contact.move_to(normal, 0, 0.8);
    contact.move_to(normal, 0.75 * normal, 0.8);
    contact.move_to(1.5 * normal, 0.35 * normal, 0.3);  // both within the new friction, both rising
    EXPECT_LT(largest_excess_over_friction(contact), 1e-9) << normal;
    EXPECT_NEAR(total_shear_n(contact), 0.35 * normal, 1e-12 * normal);
  }
}

TEST(LoadHistory, NothingIsSensedOutsideTheContact) {
  LoadHistory contact(kPair);
  contact.move_to(2, 0.4, 0.5);
  EXPECT_EQ(contact.pressure_pa(1.0000001 * contact.contact_radius_m()), 0);
  EXPECT_EQ(contact.shear_pa(1.0000001 * contact.contact_radius_m()), 0);
}

TEST(LoadHistory, AnyPathKeepsForceFrictionLawAndIndependenceOfTheSteps) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 40; ++trial) {
    LoadHistory coarse(kPair), fine(kPair);
    double normal = 0, shear = 0;
    for (int step = 0; step < 12; ++step) {
      const double to_normal = 0.5 + 3 * unit(random),
                   to_shear = 0.98 * (2 * unit(random) - 1) * 0.5 * to_normal;
      coarse.move_to(to_normal, to_shear, 0.5);
      for (int i = 1; i <= 37; ++i) {
        const double f = i / 37.0;
        fine.move_to(normal + f * (to_normal - normal), shear + f * (to_shear - shear), 0.5);
      }
      normal = to_normal;
      shear = to_shear;
      EXPECT_NEAR(total_shear_n(coarse), to_shear, 1e-12 * to_normal);
      EXPECT_LT(largest_excess_over_friction(coarse), 1e-9);
      EXPECT_LT(largest_excess_over_friction(fine), 1e-9);
      // Exact, except for paths that unload across both limits: the history follows those in 64 parts.
      EXPECT_LT(distance(coarse, fine), 1e-6) << "trial " << trial << " step " << step;
    }
  }
}

TEST(LoadHistory, NeitherGrowsNorSlowsUnderEndlessIrregularLoads) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  LoadHistory contact(kPair, 32);
  for (int step = 0; step < 20000; ++step) {
    const double normal = 0.5 + 4 * unit(random);
    contact.move_to(normal, 0.5 * normal * (2 * unit(random) - 1), 0.5);
    ASSERT_LE(contact.shear_terms().size(), 32U);
  }
  EXPECT_NEAR(total_shear_n(contact), contact.shear_n(), 1e-2 * contact.normal_n());
}

TEST(LoadHistory, MeaninglessLoadsAreRefusedAndLeaveTheStateAsItWas) {
  LoadHistory contact(kPair);
  contact.move_to(2, 0.4, 0.5);
  EXPECT_THROW(contact.move_to(-1, 0, 0.5), ContactError);
  EXPECT_THROW(contact.move_to(1, std::nan(""), 0.5), ContactError);
  EXPECT_THROW(contact.move_to(1, 0, 0), ContactError);
  EXPECT_DOUBLE_EQ(contact.normal_n(), 2);
  EXPECT_NEAR(total_shear_n(contact), 0.4, 1e-12);
}

}  // namespace
}  // namespace slipd::contact
