#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <stdexcept>
#include <vector>

#include "core/contact/imprint.hpp"
#include "core/estimate/chain.hpp"
#include "core/estimate/model_setup.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

// Gripped, pulled to 0.85 of mu P, let go to 0.2, gripped harder; at 200 Hz.
TEST(Chains, UnderASkinFollowAnUnloadingAndARegrip) {
  ChainSetup setup{
      .layout = TaxelLayout::grid(16, 16, 0.001), .scene = {}, .estimator = {}, .alerts = {}, .friction = {}};
  setup.scene.skin.depth_m = 0.001;
  EstimatorChain chain(setup, nullptr);
  contact::ImprintSheet sheet(setup.layout, {.depth_m = 0.001});
  contact::LoadHistory contact(synthetic::paper_pair());
  std::mt19937_64 random(3);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<float> p(setup.layout.size()), x(p.size()), y(p.size());
  constexpr double kFriction = 0.5;
  struct Leg {
    double normal_n, load;  // at its end: P, and Q over mu times 3 N
    int frames;
    bool judged;
  };
  constexpr Leg kLegs[] = {{3, 0, 40, false}, {3, 0.85, 80, false}, {3, 0.2, 60, true}, {4.5, 0.2, 40, true}};
  std::int64_t frame = 0;
  double normal_n = 0, load = 0, error = 0, judged = 0, answered = 0, too_high = 0;
  for (const Leg& leg : kLegs) {
    for (int i = 1; i <= leg.frames; ++i) {
      const double part = static_cast<double>(i) / leg.frames;
      contact.move_to(normal_n + part * (leg.normal_n - normal_n),
                      (load + part * (leg.load - load)) * kFriction * 3, kFriction);
      sheet.feel(contact, 0.0004, -0.0007, 0.6, p, x, y);
      for (auto* channel : {&p, &x, &y}) {
        for (float& value : *channel) value += 300 * unit(random);
      }
      ++frame;
      const Estimate estimate =
          chain.estimate({static_cast<std::uint64_t>(frame), 5'000'000 * frame, p, x, y});
      too_high += estimate.gamma_low.value_or(0) > contact.safety_margin() ? 1 : 0;
      if (!leg.judged) continue;
      ++judged;
      if (!estimate.gamma) continue;
      ++answered;
      error += std::fabs(*estimate.gamma - contact.safety_margin());
      EXPECT_LT(*estimate.gamma - contact.safety_margin(), 0.15);
    }
    normal_n = leg.normal_n;
    load = leg.load;
  }
  EXPECT_LT(too_high, 0.05 * static_cast<double>(frame));
  EXPECT_GT(answered, 0.7 * judged);
  EXPECT_LT(error / answered, 0.08);
}

// A grip that closes and is pulled until it slides, at 200 Hz.
TEST(Chains, UnderASkinFollowAGrasp) {
  ChainSetup setup{
      .layout = TaxelLayout::grid(16, 16, 0.001), .scene = {}, .estimator = {}, .alerts = {}, .friction = {}};
  setup.scene.skin.depth_m = 0.001;
  setup.estimator.method = MethodChoice::fit;
  EstimatorChain chain(setup, nullptr);
  contact::ImprintSheet sheet(setup.layout, {.depth_m = 0.001});
  contact::LoadHistory contact(synthetic::paper_pair());
  std::mt19937_64 random(3);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<float> p(setup.layout.size()), x(p.size()), y(p.size());
  constexpr int kClosing = 40, kPull = 120;
  constexpr double kGrip = 3, kFriction = 0.5;
  int answered = 0, pulled = 0;
  double error = 0, force = 0;
  for (int i = 1; i <= kClosing + kPull; ++i) {
    const double closed = std::min(1.0, static_cast<double>(i) / kClosing),
                 load = std::max(0.0, static_cast<double>(i - kClosing) / kPull);
    contact.move_to(kGrip * closed, load * kFriction * kGrip, kFriction);
    sheet.feel(contact, 0.0004, -0.0007, 0.6, p, x, y);
    for (auto* channel : {&p, &x, &y}) {
      for (float& value : *channel) value += 300 * unit(random);
    }
    const Estimate estimate =
        chain.estimate({static_cast<std::uint64_t>(i), std::int64_t{5'000'000} * i, p, x, y});
    if (load < 0.2) continue;
    ++pulled;
    if (estimate.state != State::ok) continue;
    ++answered;
    error += std::fabs(*estimate.gamma - (1 - load));
    force += estimate.normal_n.value_or(0);
    EXPECT_LT(*estimate.gamma - (1 - load), 0.1);
  }
  EXPECT_GT(answered, 0.9 * pulled);
  EXPECT_LT(error / answered, 0.035);
  EXPECT_NEAR(force / answered, kGrip, 0.05 * kGrip);
}

TEST(Chains, UnderASkinTakeMethodFitAndRefuseTheOthers) {
  ChainSetup setup{
      .layout = TaxelLayout::grid(16, 16, 0.001), .scene = {}, .estimator = {}, .alerts = {}, .friction = {}};
  setup.scene.skin.depth_m = 0.001;
  setup.estimator.method = MethodChoice::automatic;
  EXPECT_EQ(EstimatorChain(setup, nullptr).method(), Method::fit);
  for (const MethodChoice method : {MethodChoice::moments, MethodChoice::registered, MethodChoice::svd_knn}) {
    setup.estimator.method = method;
    EXPECT_FALSE(needs_model(setup));
    EXPECT_THROW(EstimatorChain(setup, nullptr), std::invalid_argument);
  }
}

}  // namespace
}  // namespace slipd
