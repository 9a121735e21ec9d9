// The law of slipd-grip, without a gripper and without a clock: what it may never do, whatever comes, and
// what it does with a margin.
#include "grip/law.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <fstream>
#include <set>
#include <sstream>

#include "core/numeric/random.hpp"
#include "tests/grip/held.hpp"

namespace slipd::grip {
namespace {

TEST(Law, OrdersNothingUntilItIsToldTo) {
  Held held;
  EXPECT_EQ(held.steps(unknown(false), 1), Order{});
  EXPECT_EQ(held.law.state(), State::idle);
}

TEST(Law, FindsAnObjectInTheGripAfterItsStartAndHoldsItFirmlyAtOnce) {
  Held held;
  const Order first = held.step(unknown(true));
  EXPECT_EQ(first.move, Move::grip);
  EXPECT_EQ(first.force_n, held.settings.firm_n) << "a ramp would let go of what is held";
}

TEST(Law, HoldsFirmlyFirstWhatItFindsThoughItSlips) {
  Held held;
  Reading slip = unknown(true);
  slip.slips = true;
  EXPECT_EQ(held.step(slip).force_n, held.settings.firm_n);
  EXPECT_EQ(held.law.state(), State::firm);
  held.step(slip);
  EXPECT_EQ(held.law.state(), State::reacting);
}

TEST(Law, ToldToCloseAfterItsStartLeavesNoObjectThatMayBeHeldWithLess) {
  for (const auto& contact : {std::optional(true), std::optional<bool>()}) {  // nullopt: slipd is away
    Held held;
    EXPECT_EQ(held.step(unknown(contact), Wish::close).force_n, held.settings.firm_n);
    EXPECT_EQ(held.law.state(), State::firm);
  }
  Held nothing;
  EXPECT_LE(nothing.step(unknown(false), Wish::close).force_n, nothing.settings.close_n)
      << "between open fingers there is nothing to hold";
}

TEST(Law, TakesNoPauseOfItsOwnForTimeInWhichTheMarginStood) {
  LawSettings settings;
  settings.settle_s = 3;
  Held held(settings);
  held.close();
  held.step(unknown(true));  // firm, which is more than this margin needs
  held.steps(margin_of(0.9), 0.6);
  const double before_n = held.law.force_n();
  ASSERT_EQ(held.law.state(), State::holding);
  held.now_ns += 4'000'000'000;
  EXPECT_EQ(held.step(margin_of(0.9)).force_n, before_n);
  held.steps(margin_of(0.9), settings.settle_s - 0.1);
  EXPECT_EQ(held.law.force_n(), before_n) << "the margin has to stand anew";
  held.steps(margin_of(0.9), 0.5);
  EXPECT_LT(held.law.force_n(), before_n);
}

TEST(Law, HoldsWithTheForceThatKeepsTheTargetMargin) {
  Held held;
  held.close();
  held.hold(3, 20);
  const double expected = 3 / (1 - held.settings.target_margin);
  EXPECT_GE(held.law.force_n(), expected * 0.999);
  EXPECT_LE(held.law.force_n(), expected * (1 + 2 * held.settings.spare));
}

TEST(Law, GripsByWhatFrictionSurelyHoldsAndNotByWhatIsLikely) {
  Held held;
  held.close();
  held.hold(5, 4);
  const double before_n = held.law.force_n();
  Reading likely = margin_of(0.9);
  likely.gamma_low = held.settings.target_margin - 0.1;
  EXPECT_GT(held.step(likely).force_n, before_n);
  EXPECT_EQ(held.law.state(), State::tightening);
}

TEST(Law, AddsForceAheadOfAForecastSlip) {
  Held still, falling;
  for (Held* one : {&still, &falling}) {
    one->close();
    one->hold(3, 20);
  }
  Reading now = margin_of(still.settings.target_margin);
  still.step(now);
  now.time_to_slip_s = 0.1;
  falling.step(now);
  EXPECT_GT(falling.law.force_n(), still.law.force_n());
  EXPECT_EQ(falling.law.state(), State::tightening);
}

// Carries out orders as late as LawSettings::delay_s says.
class LateGripper {
 public:
  explicit LateGripper(Held& held) : held_(held), orders_(4, held.law.force_n()) {}
  double acting_n() const { return orders_.front(); }
  double ordered_n() const { return orders_.back(); }
  void step(const Reading& now) {
    orders_.pop_front();
    orders_.push_back(held_.step(now).force_n);
  }

 private:
  Held& held_;
  std::deque<double> orders_;
};

// A pull that grows steadily, as in a lift.
TEST(Law, IsAheadOfALoadThatGrows) {
  LawSettings settings;
  settings.target_margin = 0.1;
  Held held(settings);
  held.close();
  held.hold(3, 20);
  LateGripper gripper(held);
  for (double needed_n = 3; needed_n < 10; needed_n += 0.2) {  // 40 N a second
    if (needed_n >= 5) {                                       // that it grows has to show first
      EXPECT_GE(gripper.acting_n(), needed_n);
    }
    Reading now = margin_of(std::max(0.0, 1 - needed_n / gripper.acting_n()));
    now.shear_n = kShearN / 3 * needed_n;
    gripper.step(now);
  }
}

TEST(Law, DoesNotTakeNoiseOfTheLoadForGrowth) {
  const RandomStream random(1);
  std::uint64_t next = 0;
  Held held;
  held.close();
  held.hold(3, 20);
  const double before_n = held.law.force_n();
  LateGripper gripper(held);
  for (int i = 0; i < 2000; ++i) {
    Reading now = margin_of(1 - 3 / gripper.acting_n());
    now.shear_n = kShearN * (1 + random.uniform(next++, -0.03, 0.03));
    gripper.step(now);
    EXPECT_LT(gripper.ordered_n(), 1.1 * before_n);
  }
}

TEST(Law, AnswersASlipWithinTheSameStep) {
  Held held;
  held.close();
  held.hold(3, 20);
  const double before = held.law.force_n();
  Reading slip = margin_of(0.05);
  slip.slips = true;
  EXPECT_GT(held.step(slip).force_n, before);
  EXPECT_EQ(held.law.state(), State::reacting);
}

TEST(Law, HoldsFirmlyWithoutAMargin) {
  Held held;
  held.close();
  held.hold(3, 20);
  for (const auto& contact : {std::optional(true), std::optional(false), std::optional<bool>()}) {
    held.steps(unknown(contact), 1);
    EXPECT_EQ(held.law.state(), State::firm);
    EXPECT_EQ(held.law.force_n(), held.settings.firm_n);
  }
}

TEST(Law, HoldsByTheLeastLikelyFrictionWhileFrictionIsARange) {
  Held held;
  held.close();
  held.hold(2, 20);
  Reading range = unknown(true);
  range.bounded = true;
  range.gamma_low = held.settings.target_margin - 0.1;
  const double before = held.law.force_n();
  held.step(range);
  EXPECT_EQ(held.law.state(), State::firm);
  EXPECT_GT(held.law.force_n(), before);
  EXPECT_LT(held.law.force_n(), held.settings.firm_n);
}

TEST(Law, DoesNotTakeAnOldMarginForTheEffectOfItsLastOrder) {
  LawSettings slow;
  slow.delay_s = 0.1;
  slow.ahead_s = 0;
  Held held(slow);
  held.close();
  held.hold(2, 20);
  const double before = held.law.force_n();
  // The gripper follows after its delay only; until then the margin is as it was.
  held.steps(margin_of(slow.target_margin / 2), 0.09);
  EXPECT_LE(held.law.force_n(), before * (1 - slow.target_margin / 2) / (1 - slow.target_margin) * 1.001);
}

TEST(Law, SaysThatAGripperDoesNotFollow) {
  Held held;
  held.close();
  held.hold(3, 20);
  Reading weak = margin_of(0.9);
  weak.normal_n = 0.1;
  held.steps(weak, 1);
  EXPECT_TRUE(held.law.is_deaf());
}

TEST(Law, RoundsUpToTheGrippersSteps) {
  LawSettings coarse;
  coarse.resolution_n = 3;
  coarse.most_n = 20;
  coarse.firm_n = 20;
  Held held(coarse);
  held.close();
  held.hold(4, 10);
  EXPECT_EQ(std::fmod(held.law.force_n(), 3), 0);
  EXPECT_GE(held.law.force_n(), 4 / (1 - coarse.target_margin));
  held.steps(unknown(true), 2);
  EXPECT_EQ(held.law.force_n(), 18) << "the last step below the limit";
}

TEST(Law, GivesUpClosingWithoutAnObjectAndDoesNotOpen) {
  Held held;
  held.step(unknown(false), Wish::close);
  const Order order = held.steps(unknown(false), held.settings.close_timeout_s + 1);
  EXPECT_EQ(held.law.state(), State::missed);
  EXPECT_EQ(order.move, Move::grip);
}

// Whatever comes: random readings, losses and wishes.
TEST(Law, NeverOpensUnbiddenNeverExceedsItsLimitsAndNeverLetsGoInTheDark) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const RandomStream random(seed);
    std::uint64_t next = 0;
    const auto draw = [&](double low, double high) { return random.uniform(next++, low, high); };
    LawSettings settings;
    settings.resolution_n = draw(0, 1) < 0.5 ? 0 : 0.25;
    Held held(settings);
    bool told_to_open = false;
    double known_for_s = 0;
    for (int i = 0; i < 2000; ++i) {
      const double kind = draw(0, 1);
      Reading reading = kind < 0.8 ? margin_of(draw(-0.2, 1.2))
                                   : unknown(draw(0, 1) < 0.5 ? std::optional(true) : std::nullopt);
      if (draw(0, 1) < 0.05) reading.slips = true;
      if (draw(0, 1) < 0.1) reading.time_to_slip_s = draw(0, 1);
      if (draw(0, 1) < 0.5) reading.shear_n = draw(0, 20);
      if (draw(0, 1) < 0.1) reading.increase_n = draw(0, 100);
      const Wish wish = i == 1 ? Wish::close : draw(0, 1) < 0.001 ? Wish::open : Wish::none;
      if (wish == Wish::open) told_to_open = true;
      if (wish == Wish::close) told_to_open = false;
      const double before = held.law.force_n();
      const bool held_before = is_gripping(held.law.state());
      const Order order = held.step(reading, wish, draw(0, 1) > 0.02);
      known_for_s = reading.known ? known_for_s + 1e-9 * kFrameNs : 0;
      ASSERT_EQ(order.move == Move::open, told_to_open && i > 1) << "seed " << seed << ", step " << i;
      ASSERT_LE(order.force_n, settings.most_n);
      if (order.move != Move::grip || !held_before) continue;
      ASSERT_LE(order.force_n,
                before + settings.raise_n_per_s * 1e-9 * kFrameNs + settings.resolution_n + 1e-9);
      if (known_for_s < settings.settle_s) {
        ASSERT_GE(order.force_n, before - 1e-9) << "seed " << seed << ", step " << i;
      }
    }
  }
}

TEST(Transitions, EachEventOfAStateLeadsToOneStateAndAllAreReached) {
  std::set<std::pair<State, Event>> seen;
  std::set<State> reached{State::idle};
  for (const Transition& one : transitions()) {
    EXPECT_TRUE(seen.insert({one.from, one.event}).second)
        << to_string(one.from) << ", " << to_string(one.event) << " twice";
    EXPECT_NE(one.from, one.to);
    reached.insert(one.to);
  }
  EXPECT_EQ(reached.size(), static_cast<std::size_t>(State::cut_off) + 1);
}

TEST(Transitions, OnlyTheOrderToOpenOpens) {
  for (const Transition& one : transitions())
    EXPECT_EQ(one.to == State::open, one.event == Event::open_order);
}

TEST(Transitions, ThePagesDiagramIsThatOfTheTable) {
  std::ostringstream page;
  page << std::ifstream(SLIPD_SOURCE_DIR "/docs/grip.md").rdbuf();
  EXPECT_THAT(page.str(), ::testing::HasSubstr("```mermaid\n" + diagram() + "```\n"))
      << "write what slipd-grip diagram prints into docs/grip.md";
}

}  // namespace
}  // namespace slipd::grip
