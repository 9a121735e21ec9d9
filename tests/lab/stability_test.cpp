// The adversary, the extremes and the Cramér–Rao bound with which `slipd-lab stability` and `tradeoff`
// compare methods.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "lab/cramer_rao_bound.hpp"
#include "lab/stability/condition.hpp"
#include "lab/stability/extremes.hpp"
#include "lab/stability/trials.hpp"
#include "lab/stability/turning_trials.hpp"

namespace lab {
namespace {

using slipd::NoiseKind;

TEST(Extremes, TheContactModelKeepsTwelveDigitsEverywhere) {
  for (const Axis axis : kAxes) {
    for (const double place : places_on(axis)) {
      const ContactModelError worst = model_error_at(axis, place, 10, 3);
      EXPECT_LT(worst.closed_form, 1e-12) << name_of(axis) << ' ' << place;
      // Beside the edge of the stick zone q rises like a root of the distance, and the edge is a rounded
      // number.
      EXPECT_LT(worst.history, 1e-3) << name_of(axis) << ' ' << place;
      EXPECT_LT(worst.single_angle, 1e-6) << name_of(axis) << ' ' << place;
    }
  }
}

TEST(Extremes, TheTextbookLosesALightLoad) {
  EXPECT_GT(model_error_at(Axis::load, 1e-12, 20, 3).textbook_double, 1e-6);
}

TEST(CramerRaoBound, AgreesWithAnIndependentPrototype) {
  // Relative noise of 5 % on 100, 32, 16 taxels along a side: 0.0008, 0.0041, 0.012.
  slipd::Scene scene = scene_of({});
  const auto limit = [&](std::size_t side) {
    return mean_cramer_rao_bound(layout_of({.side = side}), scene, NoiseKind::relative, 0.05, 200, 5)
        .mean_error;
  };
  EXPECT_NEAR(limit(32), 0.0041, 0.0008);
  EXPECT_NEAR(limit(16), 0.012, 0.0025);
  EXPECT_LT(limit(32), limit(16));
}

TEST(CramerRaoBound, GrowsWithNoiseInProportionWhileItIsSmall) {
  const auto layout = layout_of({.side = 16});
  const auto pair = slipd::contact::make_body_pair({0.01, 0.5e6, 0.45}, {0.02, 2e11, 0.25});
  const slipd::ContactDraw draw{2, 0.5, 0.02, 2e11, 0.25, 0.001, 0};
  const double one = cramer_rao_sigma(layout, pair, draw, 0.4, NoiseKind::sensor, 1e-4);
  EXPECT_NEAR(cramer_rao_sigma(layout, pair, draw, 0.4, NoiseKind::sensor, 3e-4) / one, 3, 1e-6);
  EXPECT_GT(cramer_rao_sigma(layout, pair, draw, 0.95, NoiseKind::sensor, 1e-4), one);
}

double sum(std::span<const float> values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

class PerturbationTest : public ::testing::Test {
 protected:
  // Perturbations of a contact in the middle of a wide pad, without noise.
  Trial trial(Perturbation perturbation, double strength) {
    return adversary_.make(perturbation, strength, scene_, 1, 4);
  }
  double force(Perturbation perturbation, double strength) {
    return sum(trial(perturbation, strength).frame.normal_pa);
  }

  const slipd::TaxelLayout layout_ = slipd::TaxelLayout::grid(32, 32, 0.001);
  slipd::Scene scene_ = [] {
    auto scene = scene_of({});
    scene.offset_m = 0;
    return scene;
  }();
  Adversary adversary_{layout_, NoiseKind::sensor, 0};
};

TEST_F(PerturbationTest, NoneIsTheContactItself) {
  const double whole = force(Perturbation::gains, 0), truth = trial(Perturbation::gains, 0).truth;
  for (std::size_t f = 0; f < kPerturbations; ++f) {
    const auto perturbation = static_cast<Perturbation>(f);
    EXPECT_NEAR(force(perturbation, strengths(perturbation).front()) / whole, 1, 1e-6)
        << name_of(perturbation);
    EXPECT_NEAR(trial(perturbation, strengths(perturbation).front()).truth, truth, 1e-9)
        << name_of(perturbation);
  }
}

TEST_F(PerturbationTest, OfSkinAndShapeLeaveTheForceAsItIs) {
  const double whole = force(Perturbation::gains, 0);
  for (const auto& [perturbation, strength] :
       {std::pair(Perturbation::blurred, 0.5), std::pair(Perturbation::elliptic, 1.5),
        std::pair(Perturbation::tilted, 0.3)})
    EXPECT_NEAR(force(perturbation, strength) / whole, 1, 0.02) << name_of(perturbation);
}

TEST_F(PerturbationTest, ARegripAndUnloadingRaiseTheMargin) {
  const double truth = trial(Perturbation::gains, 0).truth;
  EXPECT_NEAR(1 - trial(Perturbation::regripped, 0.5).truth, (1 - truth) / 1.5, 1e-9);
  EXPECT_NEAR(1 - trial(Perturbation::unloaded, 0.25).truth, (1 - truth) * 0.75, 1e-9);
  EXPECT_NEAR(trial(Perturbation::grown, 0.5).truth, truth, 1e-9);
}

TEST_F(PerturbationTest, DeadTaxelsReadNothingAndNoOtherDoes) {
  const auto frame = trial(Perturbation::dead, 0.5).frame;
  const std::vector<float> dead(frame.normal_pa.begin(), frame.normal_pa.end());
  const auto whole = trial(Perturbation::dead, 0).frame;
  std::size_t lost = 0, pressed = 0;
  for (std::size_t i = 0; i < dead.size(); ++i) {
    if (whole.normal_pa[i] <= 0) continue;
    ++pressed;
    lost += dead[i] == 0 ? 1U : 0U;
    EXPECT_TRUE(dead[i] == 0 || dead[i] == whole.normal_pa[i]);
  }
  EXPECT_NEAR(static_cast<double>(lost), 0.5 * static_cast<double>(pressed),
              0.25 * static_cast<double>(pressed));
}

TEST(Ordeals, AContactOfTheModelIsAnsweredRightlyAndAFlawCosts) {
  const auto rows = measure_perturbations({.side = 16, .contacts = 12}, [](double) {});
  const auto of = [&](Perturbation perturbation, std::size_t strength) -> const RobustnessRow& {
    return rows[static_cast<std::size_t>(perturbation) * 6 + strength];
  };
  for (const auto& statistics : of(Perturbation::blurred, 0).by_method) {
    EXPECT_GT(statistics.answered(), 0.8);
    EXPECT_LT(statistics.mean_error(), 0.06);
    EXPECT_EQ(statistics.frames(), 12);
  }
  const auto& grown = of(Perturbation::grown, 3);
  for (const auto& statistics : grown.by_method)
    EXPECT_TRUE(statistics.answered() < 0.8 || statistics.mean_error() > 0.06);
}

// Perturbations outside every estimator's model: sigma must include their effect. A perfect sigma would
// cover 95 %. A few dead taxels cost next to nothing.
TEST(Ordeals, SigmaOwnsUpToFlawsOfShapeAndSensor) {
  int judged = 0, all = 0;
  for (const auto& row : measure_perturbations({.side = 32, .contacts = 24}, [](double) {})) {
    // One frame cannot distinguish some histories, nor a constant error of shear from a load.
    if (row.what == "regripped" || row.what == "unloaded" || row.what == "grown" || row.what == "biased")
      continue;
    for (const auto& statistics : row.by_method) {
      ++all;
      if (statistics.answered() < 0.5) continue;  // out_of_model
      ++judged;
      EXPECT_GE(statistics.within(2), 0.75) << row.what << ' ' << row.strength;
      EXPECT_EQ(statistics.overestimated(), 0) << row.what << ' ' << row.strength;
      if (row.what != "dead" || row.strength > 0.05) continue;
      EXPECT_GT(statistics.answered(), 0.9) << row.strength;
      EXPECT_LT(statistics.mean_error(), 0.03) << row.strength;
    }
  }
  EXPECT_GT(judged, 0.75 * all);
}

// From a pull to a torque alone, from no load to slip, and on layouts that sense no torque.
TEST(Ordeals, UnderForceAndTorqueNoNumberIsWithoutEndAndFineArraysAreNotTooSafe) {
  int judged = 0, all = 0;
  for (const auto& row : measure_turning({.side = 32, .contacts = 6}, [](double) {})) {
    EXPECT_EQ(row.not_finite, 0U) << row.what << ' ' << row.strength;
    for (const auto& statistics : row.by_method) {
      EXPECT_EQ(statistics.frames(), 6) << row.what;
      if (row.what != "mixture" && row.what != "load") continue;
      ++all;
      if (statistics.answers() == 0) continue;
      ++judged;
      EXPECT_EQ(statistics.overestimated(), 0) << row.what << ' ' << row.strength;
    }
  }
  EXPECT_GT(judged, 0.75 * all);
}

TEST(ConditionNumber, OfFittingComesNearTheLimitAndOfMomentsDoesNot) {
  const TrialSetup setup{.side = 16, .contacts = 20};
  std::vector<NamedMethod> methods = untrained_methods(setup);
  const auto rows = condition_of(setup, methods, [](double) {});
  for (const auto& row : rows) {
    if (row.gamma < 0.15 || row.gamma > 0.85) continue;
    EXPECT_GT(row.by_method[0], row.limit);
    EXPECT_LT(row.by_method[1], 2 * row.limit);
    EXPECT_GT(row.by_method[1], 0.4 * row.limit);
  }
}

TEST(Bits, MoreBitsChangeTheMarginLess) {
  const TrialSetup setup{.side = 16, .contacts = 20};
  std::vector<NamedMethod> methods = untrained_methods(setup);
  const auto rows = bits_needed(setup, methods, [](double) {});
  EXPECT_LT(rows.back().by_method[0], 1e-5);
  EXPECT_GT(rows.front().by_method[0], 100 * rows.back().by_method[0]);
}

}  // namespace
}  // namespace lab
