// The friction filter of sensors that give forces only: what it learns from holds, drops and slides.
#include "core/friction/by_forces.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "tests/core/friction/followed_filter.hpp"

namespace slipd {
namespace {

using friction_filter::forces;
using friction_filter::kFilterPrior;
using ByForces = friction_filter::Followed<FrictionByForces>;

// Q/P that falls by a quarter from one frame to the next, faster than anything is let go: friction no longer
// holds it.
TEST(FrictionByForces, AForceOnlySensorWhoseLoadDropsBetweenFramesHasLessFriction) {
  const auto friction_after = [](int frames_of_the_drop) {
    ByForces filter(kFilterPrior);
    std::int64_t time_ns = 0;
    for (int i = 0; i < 50; ++i) filter.update(time_ns += 1'000'000, forces(3, 3 * 0.008 * i), nullptr);
    for (int i = 0; i < 200; ++i) {
      const double normal_n = 3 - 0.005 * i;
      filter.update(time_ns += 1'000'000, forces(normal_n, 0.4 * normal_n), nullptr);
    }
    for (int i = 1; i <= frames_of_the_drop; ++i)
      filter.update(time_ns += 1'000'000, forces(2, 2 * (0.4 - 0.1 * i / frames_of_the_drop)), nullptr);
    return filter->grid().friction();
  };
  const MeanSigma slowly = friction_after(50), at_once = friction_after(1);
  EXPECT_NEAR(slowly.mean, 0.4, 0.03);
  EXPECT_NEAR(at_once.mean, 0.3, 0.03) << "what it carries now";
}

TEST(FrictionByForces, ForcesThatHoldBoundFrictionFromBelow) {
  ByForces filter(kFilterPrior);
  for (int i = 1; i <= 200; ++i) filter.update(i * 1'000'000, forces(2, 1.2), nullptr);
  EXPECT_GT(filter->grid().friction().mean - filter->grid().friction().sigma, 0.58);
}

TEST(FrictionByForces, ASlideOfAForceOnlySensorTellsItsFrictionAndItFadesAfterwards) {
  FrictionFilterOptions options;
  options.force_only_changes_per_s = 2;
  ByForces filter(kFilterPrior, options);
  std::int64_t time_ns = 0;
  for (int i = 0; i < 50; ++i) filter.update(time_ns += 1'000'000, forces(3, 3 * 0.008 * i), nullptr);
  for (int i = 0; i < 200; ++i) {
    const double normal_n = 3 - 0.005 * i;
    filter.update(time_ns += 1'000'000, forces(normal_n, 0.4 * normal_n), nullptr);
  }
  EXPECT_NEAR(filter->grid().friction().mean, 0.4, 0.03);
  const double sigma = filter->grid().friction().sigma;
  EXPECT_LT(sigma, 0.04);
  for (int i = 0; i < 200; ++i) filter.update(time_ns += 10'000'000, forces(2, 0.2), nullptr);
  EXPECT_GT(filter->grid().friction().sigma, 3 * sigma);
}

TEST(FrictionByForces, ForcesOfALightTouchBoundNoStrongGrip) {
  ByForces filter(kFilterPrior);
  const double prior = filter->grid().friction().mean;
  std::int64_t time_ns = 0;
  for (int i = 0; i < 50; ++i) filter.update(time_ns += 1'000'000, forces(0.15, 0.12), nullptr);
  EXPECT_GT(filter->grid().friction().mean, 0.75);
  for (int i = 0; i < 100; ++i) {
    const double normal_n = 0.15 + 0.1 * i;
    filter.update(time_ns += 1'000'000, forces(normal_n, 0.05 * normal_n), nullptr);
  }
  EXPECT_LT(filter->grid().friction().mean, prior + 0.1);
}

TEST(FrictionByForces, AWrongFrictionIsCorrectedWithinASecondOfSliding) {
  for (const double hz : {60.0, 500.0}) {
    ByForces filter({.expected = {0.1, 1}, .spread = 0.15});
    std::int64_t time_ns = 0;
    std::uint32_t block = 0;
    const auto slide_for = [&](double seconds, double friction) {
      const std::int64_t end_ns = time_ns + static_cast<std::int64_t>(seconds * 1e9);
      for (; time_ns < end_ns; time_ns += static_cast<std::int64_t>(1e9 / hz)) {
        block = static_cast<std::uint32_t>(1 + time_ns / 50'000'000);
        filter.update(time_ns, forces(2, 2 * friction), nullptr,
                      {.sliding = Sliding::translation,
                       .for_s = 1,
                       .field = {.known = true, .coherence = 0.95, .block = block}});
      }
    };
    slide_for(3, 0.3);
    EXPECT_NEAR(filter->grid().friction().mean, 0.3, 0.03) << hz << " Hz";
    slide_for(1, 0.7);
    EXPECT_NEAR(filter->grid().friction().mean, 0.7, 0.07) << hz << " Hz";
    slide_for(1, 0.3);
    EXPECT_NEAR(filter->grid().friction().mean, 0.3, 0.04) << hz << " Hz";
  }
}

TEST(FrictionByForces, TaxelsThatCarryAgainstEachOtherSayNothingOfFriction) {
  ByForces filter(kFilterPrior);
  const double prior = filter->grid().friction().mean;
  for (int i = 1; i <= 200; ++i)
    filter.update(i * 1'000'000, forces(2, 1.6), nullptr,
                  {.sliding = Sliding::disturbed,
                   .for_s = 1,
                   .field = {.known = true, .coherence = 0.95, .internal_share = 0.3, .block = 1}});
  EXPECT_NEAR(filter->grid().friction().mean, prior, 1e-9);
}

}  // namespace
}  // namespace slipd
