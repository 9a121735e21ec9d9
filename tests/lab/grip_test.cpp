// The referee of slipd-grip judged by what is known of a held object: MuJoCo's friction does not creep, and
// the true margin of a central load is that of the sums, of one beside the grip that of the limit surface.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/contact/limit_surface.hpp"
#include "lab/grip/report.hpp"
#include "lab/grip/task.hpp"
#include "lab/grip/world.hpp"

namespace lab::grip {
namespace {

constexpr double kWeightN = 2, kFriction = 0.5;

// A ball between the pads, which have closed on it and carry its weight, so far beside their middle, m.
World holding(double force_n, double for_s, double beside_m = 0) {
  Task task;
  task.shape = Shape::sphere;
  task.center_m = {0, beside_m, 0};
  World world(task);
  while (world.time_s() < 0.5) world.step(force_n, {}, kFriction);
  const double until_s = 0.5 + for_s;
  while (world.time_s() < until_s)
    world.step(force_n, {0, 0, -kWeightN * std::min(1.0, (world.time_s() - 0.5) / 0.3)}, kFriction);
  return world;
}

TEST(GripWorld, HoldsWithoutCreep) {
  World world = holding(4, 0.8);
  const double begun_m = world.moved_m()[2];
  while (world.time_s() < 2.3) world.step(4, {0, 0, -kWeightN}, kFriction);
  EXPECT_NEAR(world.moved_m()[2], begun_m, 1e-6) << "a micrometre in a second is none";
}

TEST(GripWorld, LetsGoBelowTheLeastForce) {
  const World world = holding(0.9 * kWeightN / (2 * kFriction), 0.8);
  EXPECT_TRUE(world.slides());
  EXPECT_LT(world.moved_m()[2], -1e-3);
}

TEST(GripWorld, HasTheTrueMarginOfTheSums) {
  for (const double force_n : {3.0, 5.0}) {
    const World world = holding(force_n, 0.8);
    // The load grows by 1 % within the time in which the pads follow it.
    const double margin = 1 - kWeightN / (2 * kFriction * force_n);
    const TrueMargins margins = world.true_margins(world.moment());
    EXPECT_NEAR(margins.until_sliding, margin, 0.03);
    EXPECT_NEAR(margins.until_turning, margin, 0.05) << "a load in line turns nothing";
  }
}

// What the left pad's pillars need of friction to carry the load, if it slides or turns as a rigid body.
double least_friction(const World& world) {
  constexpr std::size_t kSide = 5;
  constexpr double kPitchM = 0.002;
  const auto place_m = [](std::size_t i) { return kPitchM * (static_cast<double>(i) - 2); };
  std::vector<float> values;
  world.read(Side::left, values);
  double normal_n = 0, x_n_m = 0, y_n_m = 0;
  for (std::size_t i = 0; i < kSide * kSide; ++i) {
    const double n = static_cast<double>(values[3 * i + 2]);
    normal_n += n;
    x_n_m += n * place_m(i % kSide);
    y_n_m += n * place_m(i / kSide);
  }
  slipd::contact::LimitSurface pillars;
  pillars.clear(0);
  double x_n = 0, y_n = 0, torque_nm = 0;
  for (std::size_t i = 0; i < kSide * kSide; ++i) {
    const double x = place_m(i % kSide) - x_n_m / normal_n, y = place_m(i / kSide) - y_n_m / normal_n;
    const double shear_x = static_cast<double>(values[3 * i]),
                 shear_y = static_cast<double>(values[3 * i + 1]);
    pillars.add(x, y, static_cast<double>(values[3 * i + 2]));
    x_n += shear_x;
    y_n += shear_y;
    torque_nm += x * shear_y - y * shear_x;
  }
  return pillars.least_friction(x_n, y_n, torque_nm).ratio;
}

TEST(GripWorld, HasTheTrueMarginOfTheLimitSurfaceUnderALoadBesideTheGrip) {
  for (const double beside_m : {0.002, 0.004}) {
    const World world = holding(5, 0.8, beside_m);
    const double margin = 1 - least_friction(world) / kFriction, of_pull = 1 - kWeightN / (2 * kFriction * 5);
    ASSERT_LT(margin, of_pull - 0.03) << "the torque counts";
    const TrueMargins margins = world.true_margins(world.moment());
    EXPECT_NEAR(margins.until_turning, margin, 0.05) << beside_m;
    EXPECT_GE(margins.until_sliding, margins.until_turning);
  }
}

TEST(GripTasks, AreTheSameForTheSameNumberAndWithinTheirRanges) {
  for (std::uint64_t number = 1; number < 200; ++number) {
    const Task one = draw_task(number), again = draw_task(number);
    EXPECT_EQ(describe(one), describe(again));
    EXPECT_GE(one.mass_kg, 0.05);
    EXPECT_LE(one.mass_kg, 0.8);
    EXPECT_LE(one.friction, 1);
    EXPECT_LE(one.lowest_friction(), one.friction);
    EXPECT_EQ(one.load_n(0)[2], 0) << "it stands on a table";
  }
}

TEST(GripSummary, CountsAMarginThatClaimsTooMuch) {
  TrialResult trial;
  trial.moved_m = 0.006;
  trial.reactions_frames = {0, 1, 1, 5};
  trial.slides_unanswered = 2;
  trial.probes = {{.time_s = 0, .truth = {0.5, 0.4}, .gamma = 0.75, .gamma_low = 0.4, .force_n = 1},
                  {.time_s = 1, .truth = {0.5, 0.4}, .gamma = 0.45, .gamma_low = 0.6, .force_n = 1},
                  {.time_s = 2, .truth = {0, 0}, .gamma = {}, .gamma_low = {}, .force_n = 1}};
  const GripSummary sum = summarise({trial}, {});
  EXPECT_EQ(sum.moved, 1U);
  EXPECT_NEAR(sum.sliding.margin_error, 0.15, 1e-12);
  EXPECT_EQ(sum.sliding.too_safe_share, 0.5);
  EXPECT_NEAR(sum.turning.margin_error, 0.2, 1e-12);
  EXPECT_EQ(sum.turning.too_safe_share, 0.5);
  EXPECT_EQ(sum.sliding.low_above_truth_share, 0.5);
  EXPECT_EQ(sum.sliding.force_over_least, 2);
  EXPECT_EQ(sum.answered_slides, 4U);
  EXPECT_EQ(sum.unanswered_slides, 2U);
  EXPECT_EQ(sum.reaction_median_frames, 1);
  EXPECT_EQ(sum.reaction_p99_frames, 5);
}

}  // namespace
}  // namespace lab::grip
