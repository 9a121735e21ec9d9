// Whether sigma is meant over a grasp's life: whole grasps in frame time against the truth.
#include <gtest/gtest.h>

#include <optional>

#include "lab/coverage/measure.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

constexpr double kNoise = 0.01;

lab::Coverage cycle_of(std::size_t side, MethodChoice method, double rate_hz, std::size_t grasps,
                       std::optional<double> friction = {}) {
  ChainSetup chain = lab::paper_chain(side, method, kNoise);
  chain.friction = friction;
  lab::CoverageSetup setup;
  setup.grasps = grasps;
  setup.rate_hz = rate_hz;
  return measure_cycle({chain, nullptr}, setup);
}

// Few grasps scatter more than many: the limits are a little wider than what `slipd-lab coverage` is asked
// for.
TEST(SigmaOverAGrasp, HoldsTheTruthAsOftenAsItSays) {
  for (const auto& [side, method] : {std::pair{4U, MethodChoice::fit}, std::pair{16U, MethodChoice::moments},
                                     std::pair{16U, MethodChoice::fit}}) {
    const lab::CoverageTally all = cycle_of(side, method, 500, 2).all;
    SCOPED_TRACE(side);
    ASSERT_GT(all.traced.answers(), 1000);
    EXPECT_GT(all.answered(), 0.7);
    EXPECT_GT(all.traced.within(2), 0.88);
    EXPECT_GT(all.traced.within(3), 0.96);
  }
}

// In a cycle friction falls twice, once while the object is held.
TEST(SigmaOverAGrasp, FrictionThatFallsBetweenTwoFramesIsNotToldTooSafeForLong) {
  constexpr std::size_t kGrasps = 8;
  constexpr double kFewFrames = 20;  // 0.4 s
  // Not `automatic`, whose choice depends on how fast this machine is.
  const lab::CoverageTally all = cycle_of(10, MethodChoice::fit, 50, kGrasps).all;
  ASSERT_GT(all.traced.answers(), 300);
  EXPECT_LE(all.traced.overestimates(), kFewFrames * kGrasps);
}

// The noise of the first touch, whose P is next to nothing, is no shear that was lost.
TEST(SigmaOverAGrasp, AGripThatNobodyPullsHasAMargin) {
  for (const std::size_t side : {4U, 8U, 16U, 32U}) {
    SCOPED_TRACE(side);
    const lab::Coverage cycle = cycle_of(side, MethodChoice::fit, 200, 4);
    EXPECT_GT(cycle.by_phase.at("02 hold").answered(), 0.9);
  }
}

// In a hold nothing but noise changes: the first seconds are told as well as any frame.
TEST(SigmaOverAGrasp, OfALoadThatIsHeldHoldsTheTruthForSeconds) {
  lab::CoverageSetup setup;
  setup.seed = 7;
  setup.grasps = 8;
  setup.rate_hz = 100;
  const lab::Coverage found =
      measure_holds({lab::paper_chain(16, MethodChoice::fit, kNoise), nullptr}, setup);
  ASSERT_NEAR(found.by_phase.at("3 until 20 s").frames(), 8 * 1500, 8);
  for (const char* const phase : {"1 first second", "2 until 5 s"}) {
    EXPECT_GT(found.by_phase.at(phase).answered(), 0.9) << phase;
    EXPECT_GT(found.by_phase.at(phase).traced.within(2), 0.9) << phase;
  }
}

// A peak of noise is no load that came and went, and thousands of frames alike are no evidence.
TEST(SigmaOverAGrasp, OfALoadThatIsHeldHoldsTheTruthAtAKilohertzAsWell) {
  for (const MethodChoice method : {MethodChoice::moments, MethodChoice::fit}) {
    lab::CoverageSetup setup;
    setup.seed = 11;
    setup.grasps = 6;
    const lab::Coverage found = measure_holds({lab::paper_chain(16, method, kNoise), nullptr}, setup);
    const lab::CoverageTally& late = found.by_phase.at("3 until 20 s");
    SCOPED_TRACE(method == MethodChoice::fit ? "fit" : "moments");
    ASSERT_NEAR(late.frames(), 6 * 15000, 60);
    EXPECT_GT(late.answered(), 0.9);
    EXPECT_GT(late.traced.within(2), 0.9);
    EXPECT_GT(late.traced.within(3), 0.99);
    EXPECT_LT(late.traced.overestimates(), 0.01 * late.traced.answers());
  }
}

// A thousand frames of noise, in which |Q|/P falls half of the time, show no friction that fell.
TEST(SigmaOverAGrasp, OfFewTaxelsIsTrueWhileAGripCloses) {
  lab::CoverageSetup setup;
  setup.seed = 7;
  setup.grasps = 12;
  const lab::Coverage found =
      measure_histories({lab::paper_chain(4, MethodChoice::fit, kNoise), nullptr}, setup);
  const lab::CoverageTally& grip = found.by_phase.at("grip");
  ASSERT_GT(grip.traced.answers(), 500);
  EXPECT_GT(grip.answered(), 0.65);
  EXPECT_GT(grip.traced.within(3), 0.98);
}

TEST(SigmaOverAGrasp, IsNeverZero) {
  for (const std::size_t side : {4U, 16U}) {
    for (const std::optional<double> friction : {std::optional<double>(), std::optional(0.6)}) {
      const lab::CoverageTally all = cycle_of(side, MethodChoice::fit, 100, 1, friction).all;
      ASSERT_GT(all.traced.answers(), 50);
      EXPECT_GT(all.least_sigma(), 0);
    }
  }
}

// A sensor without noise, or of whole numbers, measures none.
TEST(SigmaOverAGrasp, IsNotZeroWithoutNoise) {
  for (const std::size_t side : {1U, 4U, 16U}) {
    ChainSetup setup = lab::paper_chain(side, MethodChoice::automatic, 0);
    if (side == 1) setup.sensor_class = SensorClass::wrench;
    setup.friction = 0.5;
    EstimatorChain chain(setup, nullptr);
    synthetic::FrameMaker maker(setup.layout);
    contact::LoadHistory contact(synthetic::paper_pair());
    int answered = 0;
    for (const double shear_n : {0.0, 0.0, 1e-3, 0.3, 0.6, 0.0}) {
      contact.move_to(2, shear_n, 0.5);
      const Estimate estimate = chain.estimate(maker.make(contact, 0, 0, 0.3, 0));
      if (!estimate.gamma) continue;
      ++answered;
      EXPECT_GT(estimate.sigma.value(), 0) << side << " " << shear_n;
    }
    EXPECT_GE(answered, 4) << side;
  }
}

}  // namespace
}  // namespace slipd
