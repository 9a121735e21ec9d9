// Pads of 4 x 4 taxels under a skin, on frames of contacts that are known: forces, and the margin of a
// friction that is given.
#include "core/margin/pad_forces.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "core/chain/chain.hpp"
#include "core/contact/contact_field.hpp"
#include "core/reading/fit/subsurface_fit.hpp"
#include "core/reading/moments/moments.hpp"
#include "tests/support/heap_count.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

constexpr double kPitch = 0.0047;  // of commercial fingertips, m
constexpr double kMu = 0.5;

TaxelLayout pad() {
  return TaxelLayout::grid(4, 4, kPitch);
}

// Frames of a contact under a skin, with noise of 1 % of the greatest pressure.
class Sensed {
 public:
  Sensed(const TaxelLayout& layout, const contact::ContactGeometry& geometry)
      : sheet_(layout, geometry), p_(layout.size()), x_(p_.size()), y_(p_.size()) {}

  Frame sense(const contact::LoadHistory& contact, double x_m, double y_m, double pull_rad,
              double noise = 0.01) {
    sheet_.sense(contact, x_m, y_m, pull_rad, p_, x_, y_);
    const float width = static_cast<float>(noise) * *std::max_element(p_.begin(), p_.end());
    for (auto* channel : {&p_, &x_, &y_}) {
      for (float& value : *channel) value += width * std::uniform_real_distribution<float>(-1, 1)(random_);
    }
    ++sequence_;
    return {sequence_, static_cast<std::int64_t>(5'000'000 * sequence_), p_, x_, y_};
  }

 private:
  contact::ContactField sheet_;
  std::vector<float> p_, x_, y_;
  std::mt19937_64 random_{7};
  std::uint64_t sequence_ = 0;
};

contact::LoadHistory loaded(double normal_n, double most_load, double load) {
  contact::LoadHistory contact(synthetic::paper_pair());
  contact.move_to(normal_n, 0, kMu);
  contact.move_to(normal_n, most_load * kMu * normal_n, kMu);
  contact.move_to(normal_n, load * kMu * normal_n, kMu);
  return contact;
}

// Spheres, ellipses and a nearly flat punch, rising loads and unloadings.
TEST(PadForces, AreThoseThatActWhateverTheShapeTheHistoryAndThePlace) {
  struct Place {
    double x_m, y_m, pull_rad;
  };
  constexpr Place kPlaces[] = {{0, 0, 0.3}, {0.002, -0.001, 2.2}, {-0.0023, 0.0023, 4.1}};
  for (const double depth_m : {0.001, 0.002}) {
    for (const contact::ContactGeometry& geometry :
         {contact::ContactGeometry{.depth_m = depth_m},
          contact::ContactGeometry{.depth_m = depth_m, .stretch = 1.7},
          contact::ContactGeometry{.depth_m = depth_m, .power = 6},
          contact::ContactGeometry{.depth_m = depth_m, .bonded_poisson = 0.45}}) {
      Skin skin{.depth_m = depth_m};
      if (geometry.bonded_poisson) skin.base = SkinBase::rigid;
      const PadForces forces(pad(), skin);
      PatchFinder finder(pad());
      Sensed sensed(pad(), geometry);
      for (const Place& at : kPlaces) {
        for (const double most : {0.6, 0.95}) {
          const auto found =
              forces.of(finder.find(sensed.sense(loaded(3, most, 0.6), at.x_m, at.y_m, at.pull_rad, 0)));
          ASSERT_TRUE(found);
          const double shear_n = std::hypot(found->shear_x_n, found->shear_y_n);
          const double ratio = shear_n / found->normal_n;
          EXPECT_NEAR(found->normal_n, 3, 0.03 * 3) << depth_m;
          EXPECT_NEAR(ratio, 0.6 * kMu, 1.5 * forces.ratio_sigma() * 0.6 * kMu) << depth_m << " " << at.x_m;
          EXPECT_NEAR(std::remainder(std::atan2(found->shear_y_n, found->shear_x_n) - at.pull_rad, 6.2831853),
                      0, 0.05);
        }
      }
    }
  }
}

TEST(PadForces, OfPressingAloneHaveNoShear) {
  const PadForces forces(pad(), Skin{.depth_m = 0.002});
  PatchFinder finder(pad());
  Sensed sensed(pad(), {.depth_m = 0.002});
  const auto found = forces.of(finder.find(sensed.sense(loaded(3, 0, 0), 0.003, -0.002, 0, 0)));
  ASSERT_TRUE(found);
  EXPECT_LT(std::hypot(found->shear_x_n, found->shear_y_n), 0.01 * 3);
}

TEST(PadForces, OfAContactBeyondTheEdgeAreNotKnown) {
  const PadForces forces(pad(), Skin{.depth_m = 0.003});
  PatchFinder finder(pad());
  Sensed sensed(pad(), {.depth_m = 0.003});
  EXPECT_FALSE(forces.of(finder.find(sensed.sense(loaded(3, 0.6, 0.6), 0.0105, 0, 0, 0))));
}

// Under a skin hardly a taxel reads a negative pressure, and by the few of one frame noise may be next to
// nothing.
TEST(PadForces, HaveTheNoiseThatAFitLeavesOver) {
  constexpr double kDepth = 0.002, kPressed = 3, kNoise = 0.01;
  constexpr int kFrames = 60;
  const PadForces forces(pad(), Skin{.depth_m = kDepth});
  PatchFinder finder(pad());
  FewTaxelsSubsurfaceFit fit(pad(), {0.1, 0.9}, kDepth, {});
  Sensed sensed(pad(), {.depth_m = kDepth});
  const contact::LoadHistory contact = loaded(kPressed, 0.6, 0.6);
  const Frame still = sensed.sense(contact, 0.001, 0.0005, 0.7, 0);
  const double peak_pa = *std::max_element(still.normal_pa.begin(), still.normal_pa.end()),
               sigma_n = kNoise * peak_pa / std::sqrt(3.0) * pad().area_m2() * 4;  // of 16 taxels
  double least_alone = 1, variance = 0, mean = 0,
         square = 0;  // over the true variance; of Q over its deviation
  for (int i = 0; i < kFrames; ++i) {
    const ContactPatch& patch = finder.find(sensed.sense(contact, 0.001, 0.0005, 0.7, kNoise));
    const auto alone = forces.of(patch),
               fitted = forces.of(patch, fit.estimate(patch, moment_ratio(patch, pad())));
    ASSERT_TRUE(alone && fitted);
    const double true_n = sigma_n / fitted->read, said = fitted->shear_sigma_n / true_n,
                 found = std::hypot(fitted->shear_x_n, fitted->shear_y_n) / true_n;
    least_alone = std::min(least_alone, alone->shear_sigma_n / true_n);
    EXPECT_GT(said, 0.6);  // noise of 48 values less seven unknowns is known to 11 %
    variance += said * said / kFrames;
    mean += found / kFrames;
    square += found * found / kFrames;
  }
  EXPECT_LT(least_alone, 0.4);
  EXPECT_LT(variance, 1.5 * 1.5);
  EXPECT_LT(square - mean * mean, 1.4 * variance);  // of so few frames to 18 %
}

struct Outcome {
  double frames = 0, answered = 0, error = 0, within_two = 0, most_too_safe = -1;
  double low_above = 0, low_below = 0, low_most_above = -1;
};

// Gripped, pulled to 0.8 of mu P, let go to 0.3, gripped harder, pulled until it slides; at 200 Hz.
Outcome grasps(double depth_m, double depth_taken_m, const std::optional<KnownFriction>& friction) {
  struct Leg {
    double normal_n, load;  // at its end: P, and Q over mu times 3 N
    int frames;
    bool judged;
  };
  constexpr Leg kLegs[] = {
      {3, 0, 20, false}, {3, 0.8, 40, true}, {3, 0.3, 20, true}, {4.5, 0.3, 20, true}, {4.5, 1.5, 40, true}};
  Outcome outcome;
  Sensed sensed(pad(), {.depth_m = depth_m});
  for (int grasp = 0; grasp < 4; ++grasp) {
    ChainSetup setup{.layout = pad(), .scene = {}, .estimator = {}, .alerts = {}, .friction = friction};
    setup.scene.skin.depth_m = depth_taken_m;
    EstimatorChain chain(setup, nullptr);
    contact::LoadHistory contact(synthetic::paper_pair());
    double normal_n = 0, load = 0;
    const double x_m = 0.0017 * std::cos(1.7 * grasp), y_m = 0.0017 * std::sin(2.9 * grasp);
    for (const Leg& leg : kLegs) {
      for (int i = 1; i <= leg.frames; ++i) {
        const double part = static_cast<double>(i) / leg.frames;
        contact.move_to(normal_n + part * (leg.normal_n - normal_n),
                        (load + part * (leg.load - load)) * kMu * 3, kMu);
        const Frame frame = sensed.sense(contact, x_m, y_m, 1.3 * grasp);
        const std::uint64_t before = test::allocations();
        const Estimate estimate = chain.estimate(frame);
        EXPECT_EQ(test::allocations(), before);
        if (!leg.judged) continue;
        const double truth = contact.safety_margin();
        outcome.frames += 1;
        const double above = estimate.gamma_low.value_or(0) - truth;
        outcome.low_above += above > 0 ? 1 : 0;
        outcome.low_below += std::max(0.0, -above);
        outcome.low_most_above = std::max(outcome.low_most_above, above);
        if (!estimate.gamma) continue;
        const double off = *estimate.gamma - truth;
        outcome.answered += 1;
        outcome.error += std::fabs(off);
        outcome.within_two += std::fabs(off) < 2 * *estimate.sigma ? 1 : 0;
        outcome.most_too_safe = std::max(outcome.most_too_safe, off);
      }
      normal_n = leg.normal_n;
      load = leg.load;
    }
  }
  outcome.error /= outcome.answered;
  outcome.within_two /= outcome.answered;
  outcome.answered /= outcome.frames;
  outcome.low_above /= outcome.frames;
  outcome.low_below /= outcome.frames;
  return outcome;
}

TEST(Chains, OfFewTaxelsUnderASkinGiveTheMarginOfAFrictionThatIsGiven) {
  for (const double depth_m : {0.001, 0.002}) {
    const Outcome outcome = grasps(depth_m, depth_m, KnownFriction(kMu));
    EXPECT_GT(outcome.answered, 0.95);
    EXPECT_LT(outcome.error, 0.03);
    EXPECT_GT(outcome.within_two, 0.93);
    EXPECT_LT(outcome.most_too_safe, 0.1);
    EXPECT_LT(outcome.low_above, 0.05);
    EXPECT_LT(outcome.low_below, 0.12);
  }
}

TEST(Chains, OfFewTaxelsUnderASkinBoundTheMarginByARangeOfFriction) {
  const Outcome outcome = grasps(0.001, 0.001, KnownFriction(Range{0.4, 0.65}));
  EXPECT_LT(outcome.low_above, 0.05);
  EXPECT_LT(outcome.low_below, 0.25);
  EXPECT_LT(outcome.low_most_above, 0.03);
  EXPECT_GT(outcome.answered, 0.9);
  EXPECT_LT(outcome.most_too_safe, 0.15);
}

TEST(Chains, OfFewTaxelsUnderASkinAreNotTooSafeAtADepthThatIsAQuarterWrong) {
  for (const double taken : {0.75, 1.25}) {
    const Outcome outcome = grasps(0.002, taken * 0.002, KnownFriction(kMu));
    EXPECT_GT(outcome.within_two, 0.9) << taken;
    EXPECT_LT(outcome.most_too_safe, 0.15) << taken;
  }
}

}  // namespace
}  // namespace slipd
