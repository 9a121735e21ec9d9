// The chain's alerts on frames at 1 kHz, in frame time: when they are raised and when they end.
#include "core/chain/chain.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "core/advice/alert.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

constexpr double kSkinRadius_m = 0.01;
constexpr double kChainFriction = 0.5;

ChainSetup setup_16() {
  ChainSetup setup{.layout = TaxelLayout::grid(16, 16, 0.9e-3),
                   .scene = {},
                   .estimator = {.method = MethodChoice::moments},
                   .alerts = {},
                   .friction = {}};
  setup.scene.skin.radius_m = kSkinRadius_m;
  setup.scene.objects = paper_objects();
  return setup;
}

class Chain : public ::testing::Test {
 protected:
  // One frame each millisecond, up to the given forces.
  std::vector<Estimate> press(int ms, double normal_n, double shear_n, double noise = 0.01) {
    std::vector<Estimate> estimates;
    const double from_normal_n = normal_n_, from_shear_n = shear_n_;
    for (int i = 1; i <= ms; ++i) {
      const double f = static_cast<double>(i) / ms;
      normal_n_ = from_normal_n + f * (normal_n - from_normal_n);
      shear_n_ = from_shear_n + f * (shear_n - from_shear_n);
      contact_.move_to(normal_n_, shear_n_, kChainFriction);
      estimates.push_back(chain_.estimate(maker_.make(contact_, 0, 0, 0.3, noise)));
    }
    return estimates;
  }

  ChainSetup setup_ = setup_16();
  EstimatorChain chain_{setup_, nullptr};
  synthetic::FrameMaker maker_{setup_.layout};
  contact::LoadHistory contact_{synthetic::paper_pair()};
  double normal_n_ = 0, shear_n_ = 0;
};

TEST_F(Chain, TheFirstFrameWhoseMarginHasStayedLowForLongEnoughRaisesTheAlert) {
  press(100, 2, 0);
  const auto estimates = press(200, 2, 0.98);
  const auto low = [&](const Estimate& e, double threshold) {
    return e.gamma && *e.gamma - sigmas_for(setup_.alerts.cost) * *e.sigma < threshold;
  };
  for (const auto& [level, threshold] :
       {std::pair{Alert::warn, setup_.alerts.warn_below}, std::pair{Alert::slip, setup_.alerts.slip_below}}) {
    std::size_t raised = 0;
    while (raised < estimates.size() &&
           !(is_raised(estimates[raised].alert) && estimates[raised].alert >= level))
      ++raised;
    ASSERT_LT(raised, estimates.size());
    int low_for = 0;  // frames; 2 ms are over with the third
    for (std::size_t i = 0; i <= raised; ++i) {
      low_for = low(estimates[i], threshold) ? low_for + 1 : 0;
      EXPECT_EQ(low_for >= 3, i == raised) << i << " of " << raised;
    }
  }
}

TEST_F(Chain, AnAlertOutlastsAnUnknownMarginAndEndsWithASaferGripOrWithoutContact) {
  press(100, 2, 0);
  ASSERT_EQ(press(200, 2, 0.95).back().alert, Alert::slip);
  int doubted = 0;
  for (const Estimate& each : press(50, 2, 0.95, 0.3)) {  // too noisy for a margin
    if (!each.gamma) ++doubted;
    EXPECT_EQ(each.alert, Alert::slip) << to_string(each.state);
  }
  EXPECT_GT(doubted, 0);
  EXPECT_EQ(press(300, 6, 0.95).back().alert, Alert::none);
  ASSERT_TRUE(is_raised(press(300, 1.5, 0.95).back().alert)) << "beyond what friction holds";
  EXPECT_EQ(press(50, 0, 0).back().alert, Alert::none);
}

TEST_F(Chain, TheContactRadiusIsGivenRelativeToTheSkinRadiusToo) {
  const Estimate last = press(100, 2, 0.3).back();
  EXPECT_DOUBLE_EQ(last.a_over_r.value(), *last.radius_m / kSkinRadius_m);
  setup_.scene.skin.radius_m = std::numeric_limits<double>::infinity();
  chain_ = EstimatorChain(setup_, nullptr);
  EXPECT_FALSE(press(10, 2, 0.3).back().a_over_r) << "a flat skin has none";
}

constexpr MethodChoice kChoices[] = {MethodChoice::automatic, MethodChoice::svd_knn, MethodChoice::registered,
                                     MethodChoice::moments,   MethodChoice::fit,     MethodChoice::closing,
                                     MethodChoice::block_fit};

ChainSetup setup_of(MethodChoice method, std::size_t columns, std::size_t rows) {
  ChainSetup setup = setup_16();
  setup.layout = TaxelLayout::grid(columns, rows, 2e-3);
  setup.estimator.method = method;
  return setup;
}

TEST(ChainsMethod, IsFitForUpTo40TrackedTaxelsWhateverIsConfiguredAndNeedsNoModel) {
  for (const MethodChoice method : kChoices) {
    for (const auto& [columns, rows] : {std::pair{4, 4}, std::pair{8, 5}}) {
      const ChainSetup setup = setup_of(method, columns, rows);
      EXPECT_TRUE(fits_whole_pad(setup));
      EXPECT_FALSE(needs_model(setup));
      EXPECT_EQ(EstimatorChain(setup, nullptr).method(), Method::fit);
    }
  }
}

TEST(ChainsMethod, IsTheConfiguredOneForMoreTaxelsAndWithoutTracking) {
  for (const MethodChoice method : kChoices) {
    ChainSetup setup = setup_of(method, 41, 1);
    const bool trained = method == MethodChoice::svd_knn || method == MethodChoice::registered;
    EXPECT_FALSE(fits_whole_pad(setup));
    EXPECT_EQ(needs_model(setup), trained);
    setup = setup_of(method, 4, 4);
    setup.estimator.tracking = false;
    EXPECT_FALSE(fits_whole_pad(setup));
    EXPECT_EQ(needs_model(setup), trained);
    if (trained) {
      EXPECT_THROW(EstimatorChain(setup, nullptr), std::invalid_argument);
    }
  }
}

TEST(ChainsMethod, SaysWhyItIsTheOneThatItIs) {
  const auto why = [](MethodChoice method, std::size_t columns, double depth_m = 0) {
    ChainSetup setup = setup_of(method, columns, columns);
    setup.scene.skin.depth_m = depth_m;
    return why_method(setup);
  };
  constexpr double kDepth_m = 2e-3;  // a taxel's side
  EXPECT_EQ(why(MethodChoice::moments, 8), MethodReason::configured);
  EXPECT_EQ(why(MethodChoice::automatic, 8), MethodReason::automatic);
  EXPECT_EQ(why(MethodChoice::automatic, 8, kDepth_m), MethodReason::skin);
  EXPECT_EQ(why(MethodChoice::automatic, 8, kDepth_m / 100), MethodReason::automatic) << "it is not sensed";
  EXPECT_EQ(why(MethodChoice::fit, 8, kDepth_m), MethodReason::configured);
  EXPECT_EQ(why(MethodChoice::moments, 4), MethodReason::few_taxels);
  EXPECT_EQ(why(MethodChoice::automatic, 4), MethodReason::few_taxels);
  EXPECT_EQ(why(MethodChoice::fit, 4), MethodReason::configured);
  ChainSetup setup = setup_of(MethodChoice::moments, 8, 8);
  setup.sensor_class = SensorClass::wrench;
  EXPECT_EQ(why_method(setup), MethodReason::forces);
  setup.sensor_class = SensorClass::normal;
  EXPECT_EQ(why_method(setup), MethodReason::no_shear);
}

// Without shear, or with forces only, there is nothing to fit.
TEST(ChainsMethod, IsNotFitWithoutAShape) {
  ChainSetup setup = setup_of(MethodChoice::svd_knn, 4, 4);
  for (const SensorClass other : {SensorClass::wrench, SensorClass::normal}) {
    setup.sensor_class = other;
    EXPECT_FALSE(fits_whole_pad(setup));
    EXPECT_FALSE(needs_model(setup));
    EXPECT_EQ(EstimatorChain(setup, nullptr).method(), Method::friction);
  }
}

// The margin is 1 - |Q|/(mu P) then, whatever happened in the frames that are missing.
class GivenFriction : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Pads, GivenFriction, ::testing::Bool(),
                         [](const auto& flat) { return flat.param ? "flat" : "curved"; });

TEST_P(GivenFriction, AnswersAHoldWhicheverFramesBeforeItWereLost) {
  constexpr int kCycles = 40, kHoldFrames = 60;
  constexpr double kGiven = 0.5, kLost = 0.3, kNormal_n = 3, kHeld_n = 0.9;
  ChainSetup setup = setup_of(MethodChoice::moments, 8, 8);
  setup.friction = KnownFriction{{kGiven, kGiven}};
  if (GetParam()) setup.scene.skin.radius_m = std::numeric_limits<double>::infinity();
  EstimatorChain chain(setup, nullptr);
  synthetic::FrameMaker maker(setup.layout);
  contact::LoadHistory contact(synthetic::paper_pair());
  std::mt19937_64 random(1);  // NOLINT: the same frames are lost each time
  std::uniform_real_distribution<double> unit;
  std::int64_t time_ns = 0;
  int held = 0, answered = 0;
  const auto move = [&](int frames, double from_n, double to_n, double from_shear_n, double to_shear_n) {
    for (int i = 1; i <= frames; ++i) {
      const double share = static_cast<double>(i) / frames;
      time_ns += 50'000'000;
      contact.move_to(from_n + share * (to_n - from_n), from_shear_n + share * (to_shear_n - from_shear_n),
                      kGiven);
      Frame frame = maker.make(contact, 0, 0, 0, 0.003);
      frame.time_ns = time_ns;
      if (unit(random) < kLost) continue;
      const Estimate estimate = chain.estimate(frame);
      if (frames != kHoldFrames) continue;
      ++held;
      if (!estimate.gamma) continue;
      ++answered;
      EXPECT_NEAR(*estimate.gamma, 1 - kHeld_n / (kGiven * kNormal_n), 0.03);
    }
  };
  for (int cycle = 0; cycle < kCycles; ++cycle) {
    move(20, 0, 0, 0, 0);
    move(6, 0, kNormal_n, 0, 0);
    move(12, kNormal_n, kNormal_n, 0, kGiven * kNormal_n);
    move(6, kNormal_n, kNormal_n, kGiven * kNormal_n, kHeld_n);
    move(kHoldFrames, kNormal_n, kNormal_n, kHeld_n, kHeld_n);
    move(3, kNormal_n, 0, kHeld_n, 0);
  }
  EXPECT_GT(held, kCycles * kHoldFrames / 2);
  EXPECT_GT(answered, 9 * held / 10);
}

}  // namespace
}  // namespace slipd
