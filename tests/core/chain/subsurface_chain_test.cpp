#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/chain/chain.hpp"
#include "core/chain/chain_parts.hpp"
#include "core/contact/contact_field.hpp"
#include "paper/model_setup.hpp"
#include "tests/support/synthetic.hpp"

namespace slipd {
namespace {

ChainSetup under_skin() {
  ChainSetup setup{
      .layout = TaxelLayout::grid(16, 16, 0.001), .scene = {}, .estimator = {}, .alerts = {}, .friction = {}};
  setup.scene.skin.depth_m = 0.001;
  return setup;
}

// Frames at 200 Hz, with noise of 300 Pa, in one chain.
class SensedGrasp {
 public:
  explicit SensedGrasp(const ChainSetup& setup)
      : chain_(setup, nullptr),
        sheet_(setup.layout, {.depth_m = setup.scene.skin.depth_m}),
        p_(setup.layout.size()),
        x_(p_.size()),
        y_(p_.size()) {}

  Estimate sense(const contact::LoadHistory& contact) {
    sheet_.sense(contact, 0.0004, -0.0007, 0.6, p_, x_, y_);
    for (auto* channel : {&p_, &x_, &y_}) {
      for (float& value : *channel) value += 300 * unit_(random_);
    }
    ++frame_;
    return chain_.estimate({static_cast<std::uint64_t>(frame_), 5'000'000 * frame_, p_, x_, y_});
  }

 private:
  EstimatorChain chain_;
  contact::ContactField sheet_;
  std::mt19937_64 random_{3};
  std::uniform_real_distribution<float> unit_{-1, 1};
  std::vector<float> p_, x_, y_;
  std::int64_t frame_ = 0;
};

// Gripped, pulled to 0.85 of mu P, let go to 0.2, gripped harder; at 200 Hz.
TEST(Chains, UnderASkinFollowAnUnloadingAndARegrip) {
  SensedGrasp grasp(under_skin());
  contact::LoadHistory contact(synthetic::paper_pair());
  constexpr double kFriction = 0.5;
  struct Leg {
    double normal_n, load;  // at its end: P, and Q over mu times 3 N
    int frames;
    bool judged;
  };
  constexpr Leg kLegs[] = {{3, 0, 40, false}, {3, 0.85, 80, false}, {3, 0.2, 60, true}, {4.5, 0.2, 40, true}};
  int frames = 0;
  double normal_n = 0, load = 0, error = 0, judged = 0, answered = 0, too_high = 0;
  for (const Leg& leg : kLegs) {
    for (int i = 1; i <= leg.frames; ++i) {
      const double part = static_cast<double>(i) / leg.frames;
      contact.move_to(normal_n + part * (leg.normal_n - normal_n),
                      (load + part * (leg.load - load)) * kFriction * 3, kFriction);
      const Estimate estimate = grasp.sense(contact);
      ++frames;
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
  EXPECT_LT(too_high, 0.05 * static_cast<double>(frames));
  EXPECT_GT(answered, 0.7 * judged);
  EXPECT_LT(error / answered, 0.08);
}

// A grip that closes and is pulled until it slides, at 200 Hz.
TEST(Chains, UnderASkinFollowAGrasp) {
  ChainSetup setup = under_skin();
  setup.estimator.method = MethodChoice::fit;
  SensedGrasp grasp(setup);
  contact::LoadHistory contact(synthetic::paper_pair());
  constexpr int kClosing = 40, kPull = 120;
  constexpr double kGrip = 3, kFriction = 0.5;
  int answered = 0, pulled = 0;
  double error = 0, force = 0;
  for (int i = 1; i <= kClosing + kPull; ++i) {
    const double closed = std::min(1.0, static_cast<double>(i) / kClosing),
                 load = std::max(0.0, static_cast<double>(i - kClosing) / kPull);
    contact.move_to(kGrip * closed, load * kFriction * kGrip, kFriction);
    const Estimate estimate = grasp.sense(contact);
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
  ChainSetup setup = under_skin();
  setup.estimator.method = MethodChoice::automatic;
  EXPECT_EQ(EstimatorChain(setup, nullptr).method(), Method::fit);
  for (const MethodChoice method : {MethodChoice::moments, MethodChoice::registered, MethodChoice::svd_knn}) {
    setup.estimator.method = method;
    EXPECT_FALSE(needs_model(setup));
    EXPECT_THROW(EstimatorChain(setup, nullptr), std::invalid_argument);
  }
}

// What --check-config says and what becomes of the sensor are the same.
TEST(Chains, UnderASkinAreRefusedForTheReasonThatIsKnownBeforehand) {
  for (const SkinBase base : {SkinBase::half_space, SkinBase::rigid}) {
    for (const auto& [name, method] : method_choices()) {
      ChainSetup setup = under_skin();
      setup.scene.skin.base = base;
      setup.estimator.method = method;
      std::string refusal;
      try {
        const EstimatorChain chain(setup, nullptr);
      } catch (const std::invalid_argument& error) {
        refusal = error.what();
      }
      const bool reads = method == MethodChoice::automatic || method == MethodChoice::fit ||
                         (method == MethodChoice::closing && base == SkinBase::half_space);
      EXPECT_EQ(refusal.empty(), reads) << name;
      EXPECT_EQ(why_method_cannot_read(setup), refusal) << name;
    }
  }
}

TEST(Chains, ThatNeedNoContactModelReadAnySkin) {
  ChainSetup setup = under_skin();
  setup.estimator.method = MethodChoice::moments;
  ASSERT_NE(why_method_cannot_read(setup), "");
  for (const SensorClass other : {SensorClass::normal, SensorClass::displacement}) {
    setup.sensor_class = other;
    EXPECT_EQ(why_method_cannot_read(setup), "");
  }
}

}  // namespace
}  // namespace slipd
